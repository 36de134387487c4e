"""Read stored final states again, after the definition of a measurement has changed."""

from fastapi import APIRouter

from service import remeasuring
from service.keys import Submitter
from service.remeasure_schemas import RemeasureModel
from service.routes.given import StoreGiven, SweepId

router = APIRouter(prefix="/v1/sweeps", tags=["sweeps"])


@router.post("/{id}/remeasure", status_code=202)
def remeasure_sweep(id: SweepId, caller: Submitter, store: StoreGiven) -> RemeasureModel:
    """Read what is of an older definition off the stored final states, and publish again. Nothing is solved.

    The answer says of how many runs that will be so. Runs whose final state was not kept are named,
    and stay as they are. Other sweeps that use the same runs are published again, too. When it is
    done, the events of the sweep say `remeasured`, with the number of runs and the unreadable ones.
    """
    caller.check_owns(store.sweep(id))
    return RemeasureModel.of(id, remeasuring.order(store, id))
