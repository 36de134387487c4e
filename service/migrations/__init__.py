"""Changes of the tables since version 0.1.0, one a file; a store applies them when it is opened.

To change a table: edit ``service/store/tables.py`` and its ``REVISION``, from which an empty database is made, and add
``versions/v<version>_<change>.py``, an Alembic migration that brings the tables and rows of the revision
before to the same state. Called by ``service.store.connection`` alone.
"""
