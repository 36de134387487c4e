"""A PostgreSQL server for all crash tests of a session, and an empty database for each."""

from tests.service.conftest import postgresql, postgresql_url

__all__ = ["postgresql", "postgresql_url"]
