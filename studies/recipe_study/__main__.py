"""``python -m studies.recipe_study DIRECTORY``: compute the study and draw it."""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from studies.recipe_study.measure import measured
from studies.recipe_study.variants import variants

PROCESSES = 2


def main(directory: Path) -> None:
    """Compute every variant."""
    directory.mkdir(parents=True, exist_ok=True)
    file = directory / "results.json"
    results = json.loads(file.read_text()) if file.exists() else {}
    missing = [variant for variant in variants() if variant.name not in results]
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        jobs = {variant: pool.submit(measured, variant.recipe) for variant in missing}
        for variant, job in jobs.items():
            results[variant.name] = {"group": variant.group, **job.result()}
            file.write_text(json.dumps(results, indent=1))
            print(variant.name, flush=True)
    try:
        from studies.recipe_study.figures import draw
    except ImportError:
        print("the figures need the extra: pip install whipple[figures]")
        return
    draw(results, directory)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
