"""How fast Deixis grounds, beside other ways to do the same job: ``make bench`` prints it.

Nothing here is asserted; that the others find the same answers is, in ``tests/test_oracles.py``.
"""
