"""What holds for every test of studies: results are invented, so that no ensemble says how far their meshes are off."""

from collections.abc import Iterator

import pytest

from studies.convergence import experience


@pytest.fixture(scope="module", autouse=True)
def unknown_mesh_errors() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(experience, "stored", dict)
        yield
