/** <module> Load every rule file, ask a comment of every export, run every PlUnit file

From the top of the checkout, so that a warning fails it too:

    swipl --on-error=status --on-warning=status -p deixis=rules -g main tests/rules/run.pl

Exits 0 only if there are rule files and test files, all of them load silently, no predicate they call is
undefined, each exported predicate has a PlDoc comment, and all tests pass.
*/

:- module(run_rule_tests, [main/0]).
:- use_module(library(check)).
:- use_module(library(filesex)).
:- use_module(library(lists)).
:- use_module(library(plunit)).
:- use_module(library(pldoc)).
:- use_module(library(pldoc/doc_process)).

:- set_prolog_flag(encoding, utf8).   % whatever the locale is
:- doc_collect(true).

%!  main is det.
%
%   Do all of the above and halt.

main :-
    module_property(run_rule_tests, file(Here)),
    file_directory_name(Here, Tests),
    absolute_file_name(deixis(.), Rules, [file_type(directory)]),
    (   files(Rules, ['*.pl', '*/*.pl'], RuleFiles),
        files(Tests, ['*.plt'], TestFiles),
        load(RuleFiles, [imports([])]),   % apart: two rule files may export one name
        documented(RuleFiles),
        load(TestFiles, []),
        list_undefined,
        run_tests
    ->  halt                    % unlike halt(0) it exits 1 if an error or a warning was printed
    ;   halt(1)
    ).

%   files(+Directory, +Patterns, -Files): what matches; false, and says so, if nothing does.

files(Directory, Patterns, Files) :-
    findall(File,
            ( member(Pattern, Patterns),
              directory_file_path(Directory, Pattern, Glob),
              expand_file_name(Glob, Matches),
              member(File, Matches),
              exists_file(File)
            ),
            Files),
    (   Files == []
    ->  print_message(error, format("nothing in ~w is like ~w", [Directory, Patterns])),
        fail
    ;   true
    ).

%   load(+Files, +Options): into user, where a name of the libraries imported above is still free.

load(Files, Options) :-
    load_files(user:Files, [must_be_module(false), if(not_loaded)|Options]).

%   documented(+Files): true if each predicate exported there has a PlDoc comment; names those without.

documented(Files) :-
    findall(Module:Name/Arity,
            ( member(File, Files),
              module_property(Module, file(File)),
              module_property(Module, exports(Exports)),
              member(Name/Arity, Exports),
              functor(Head, Name, Arity),
              \+ predicate_property(Module:Head, imported_from(_)),
              \+ doc_comment(Module:Name/Arity, _, _, _)
            ),
            Missing),
    (   Missing == []
    ->  true
    ;   print_message(error, format("exported without a PlDoc comment: ~w", [Missing])),
        fail
    ).
