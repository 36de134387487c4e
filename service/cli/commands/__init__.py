"""The subcommands of ``whipple``, by whom they talk to.

``computing``: this machine, without a service. ``serving``: the service itself. ``asking``: a service,
over HTTP. ``keeping``: the database and the files of a service, where they are. How to add one: a
function in one of these with ``@app.command()``; what is heavy is imported inside of it.
"""
