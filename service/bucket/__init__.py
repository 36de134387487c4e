"""Files in a bucket, for ``WHIPPLE_ARTIFACTS=s3://BUCKET/PREFIX``: ``bucket`` reads and writes its objects, and
``keeping`` removes those that no row names. S3 needs the extra ``s3``.
"""
