:- module(words,
          [ language/1,                 % ?Language
            speaks/1,                   % ?Language
            saying/3                    % +Name, +Args, -Text
          ]).
:- use_module(lang/en, []).

/** <module> Which language is spoken

A language is a file in lang/ that defines the predicates of lang/en.pl in a module of its own name and says
so by a clause of speaks/1. Whoever makes sentences asks language/1 for the module to look in, so that no
other file knows a language by its name.
*/

:- multifile speaks/1.
:- dynamic speaks/1.

%!  speaks(?Language) is nondet.
%
%   The file of Language is loaded.

%!  language(?Language) is det.
%
%   Language is what sentences are in: English, unless another one is loaded as well.

language(Language) :-
    (   speaks(Other),
        Other \== en
    ->  Language = Other
    ;   Language = en
    ).

%!  saying(+Name, +Args, -Text:string) is det.
%
%   Text is what the language says by Name, filled in with Args.

%
%   Fails where the language has no words for it.

saying(Name, Args, Text) :-
    language(Words),
    Words:said(Name, Format),
    format(string(Text), Format, Args).
