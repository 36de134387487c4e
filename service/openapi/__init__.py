"""The OpenAPI document of the interface, at ``/openapi.json``."""
