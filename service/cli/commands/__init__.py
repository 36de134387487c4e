"""The subcommands of ``whipple``: ``computing`` on this machine without a service, ``drawing`` figures and films
into files, ``fitting`` laws to a cube, ``serving`` the service itself, ``client`` requests to a service over HTTP,
``maintenance`` of the database and files of a service.

To add one: a function in one of these with ``@app.command()``; heavy modules are imported inside of it.
"""
