"""The page: a scene, its relations and their reasons in one file that works offline.

:func:`page_data` makes the data of what others computed, :func:`page_html` puts them into the page that
`make page` bundled. Nothing here measures anything or knows a rule.
"""

from deixis.view.content import Shown, page_data
from deixis.view.html import available, framed, packed, page_html, page_text, policy_of, ready

__all__ = [
    "Shown", "available", "framed", "packed", "page_data", "page_html", "page_text", "policy_of", "ready"
]  # fmt: skip
