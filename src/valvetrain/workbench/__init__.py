"""The workbench behind ``valvetrain serve``: cases, jobs, forms, live curves and answers, without
any web framework.

The pages in ``workbench.pages`` show it in a browser; they alone know a framework.
"""
