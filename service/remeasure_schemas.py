"""What the interface answers to an order to read stored states again."""

from pydantic import Field

from service.remeasuring import Plan
from service.schemas import Answer


class RemeasureModel(Answer):
    """What is read again of a sweep; each run is counted once."""

    id: str = Field(description="of the sweep")
    remeasured: int = Field(description="runs that are read again now, in the queue")
    up_to_date: int = Field(description="runs that were measured by today's definitions")
    not_kept: int = Field(description="outdated runs without a stored final state: they stay")
    without_result: int = Field(
        description="runs that failed, were cancelled, or are not there yet"
    )
    not_kept_runs: list[str] = Field(description="their ids; submitted anew, they would be solved")
    links: dict[str, str]

    @classmethod
    def of(cls, id: str, plan: Plan) -> "RemeasureModel":
        """A plan as an answer."""
        here = f"/v1/sweeps/{id}"
        return cls(
            id=id,
            remeasured=len(plan.read),
            up_to_date=plan.up_to_date,
            not_kept=len(plan.not_kept),
            without_result=plan.without_result,
            not_kept_runs=list(plan.not_kept),
            links={"sweep": here, "events": f"{here}/events", "history": f"{here}/history"},
        )
