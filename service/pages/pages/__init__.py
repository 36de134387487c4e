"""Pages, one module for what belongs together.

To add one: a module here that offers its ``PageRoutes`` as ``PAGE``. A feature offers its own by an entry point of the
group ``whipple.service.pages.pages``, and names a template of its folder ``templates`` with its package:
``service.shields:shields.html``.
"""
