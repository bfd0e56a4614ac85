"""Seeds realistic faults into copies of ``src/``, one at a time, and tells the share that the tests
notice: ``make mutants``.
"""
