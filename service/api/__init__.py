"""The HTTP interface: the application, its routes and schemas, access and keys, errors.

Every row that it shows comes from the store; files are sent as bytes and never opened as datasets.
"""
