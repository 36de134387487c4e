"""The report: simulation, laws and observations side by side, as one document, its figures and its page.

``publish`` makes the files of a sweep's result from its runs; ``compare`` judges the laws, ``report`` says it,
``figures`` and ``plot`` draw it, ``page`` prints it. The top room of the studies.
"""
