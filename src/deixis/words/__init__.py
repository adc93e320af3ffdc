"""Words: what people call relations, what a scene is like in a few sentences, and answers to plain questions.

The lexicon maps English prepositions to predicates and back; ``rules/prepositions.pl`` says which of them a
person would accept of two things.
"""

from deixis.words.answering import Reply, say
from deixis.words.describing import Description, Sentence, Stated, describe
from deixis.words.lasting import Lasting
from deixis.words.lexicon import ENTRIES, NOT_GROUNDED, Entry, Sense, entry_of, predicates_in, words_for

__all__ = [
    "ENTRIES",
    "NOT_GROUNDED",
    "Description",
    "Entry",
    "Lasting",
    "Reply",
    "Sense",
    "Sentence",
    "Stated",
    "describe",
    "entry_of",
    "predicates_in",
    "say",
    "words_for",
]
