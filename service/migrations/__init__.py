"""How the tables grew, one step a file; brought up to date whenever a store is opened.

To add a step: change ``service/store/tables.py``, then write the next
``versions/v<number>_<what>.py`` after the model of
the last one. Rows of an older store must survive it.
"""
