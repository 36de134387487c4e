"""Runs the steps on the connection, inside the transaction, that ``Database.migrate`` gives."""

from alembic import context

context.configure(connection=context.config.attributes["connection"], render_as_batch=True)
with context.begin_transaction():
    context.run_migrations()
