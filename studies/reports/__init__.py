"""The report: simulation, laws and observations side by side, as one document, its figures and its page.

``publish`` makes the files of a sweep's result from its runs. ``matched`` reads the cube, ``compare``
states how far laws and observations are from it and ``verdict`` which law to use where, ``figures`` and ``captions``
say what is drawn and ``plot`` draws it, ``report`` gathers the document and ``page`` prints it. The service
calls ``publish``, and ``validation`` the verdict.
"""
