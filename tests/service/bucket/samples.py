"""What buckets offer to the tests of storms."""

from tests.service.bucket.object_store import object_store

BUCKETS = {"s3": object_store}
