"""Questions to laws answered, in a child process."""

import json

from service.api.reading import Posted


def answered(posted: Posted) -> bytes:
    """What laws and shots say of the shots of a question, as JSON; raises InvalidInput."""
    from studies.answers import answer, question

    with posted.document() as document:
        return json.dumps(answer.document(question.read_question(document)), ensure_ascii=False).encode()


def answered_as_cube(posted: Posted) -> bytes:
    """Answer a question as NetCDF-4: values of laws over the axes of what was asked."""
    from studies.answers import cube, question

    with posted.document() as document:
        return cube.netcdf(question.read_question(document))
