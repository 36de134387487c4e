"""Changes of the tables since revision 0006, one a file; a store applies them when it is opened.

To change a table: edit ``service/store/tables.py`` and its ``REVISION``, from which an empty database is made, and add
``versions/v<number>_<change>.py``, an Alembic migration that brings the tables and rows of the revision
before to the same state. Called by ``service.store.connection`` alone.
"""
