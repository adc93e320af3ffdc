"""Living scenes: relations kept while things move, come and go, at the cost of what can have changed."""

from deixis.living.kept import Known
from deixis.living.living import Difference, Living

__all__ = ["Difference", "Known", "Living"]
