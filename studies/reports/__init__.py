"""The report: simulation, laws and measured shots side by side, as one document, its figures and its page.

``publish`` makes the files of a sweep's result from its runs. ``compare`` reads the cube: ``matched``
finds the measured shots, ``judgement`` says how each law does. The files of ``sections``, and those of features, say
what stands in the document, which ``report`` gathers and ``page`` prints; ``opening`` is what comes first. ``figures``
says what is drawn, and ``drawing`` draws it.
"""
