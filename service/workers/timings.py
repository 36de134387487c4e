"""Intervals and deadlines of the queue, its engines and their processes, in one record that is passed down."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Timings:
    """Seconds; tests pass shorter ones."""

    # The dispatcher (service.queue).
    leadership_retry: float = 2.0  # interval between two tries to lead, or to start the engine
    stuck: float = 60.0  # without a successful tick, until the dispatcher counts as dead
    closing_poll: float = 0.1  # interval between two checks whether the engine has closed
    engine_retry: float = 5.0  # after the engine refused an attempt
    registration_retry: float = 5.0  # after an ending that could not be registered
    progress_interval: float = 1.0  # interval between two writes of progress
    lost_results_retry: float = 60.0  # pause of a publication that lost too many results
    backoff_first: float = 10.0  # after too many losses in a row; each further loss doubles it
    backoff_longest: float = 600.0

    # Verification of results.
    verification_wait: float = 0.1  # wait of a tick: most verifications take a few milliseconds
    last_verification_wait: float = 2.0  # when the service stops; its next life verifies the rest
    verification_retry: float = 5.0  # after files that could not be read
    # Time for a disk to recover; NFS keeps attributes as long.
    verification_retry_limit: float = 60.0

    # Garbage collection, for which the leader waits.
    collection_step: float = 0.04  # to look for orphans
    collection_drop: float = 0.01  # to look for files that no sweep retains
    temporary_file_age: float = 600.0  # a younger temporary file may still be written to

    # Comparison of stored files with their digests, for which the leader waits.
    scrub_step: float = 0.2  # to read, however much is due
    scrub_note: float = 60.0  # interval between two notes of how far it is
    scrub_interval: float = 24 * 3600.0  # between the beginnings of two passes, at least

    # The supervisor of an attempt, and its process (service.workers).
    supervisor_tick: float = 0.1  # interval between two checks of stop and limits
    stop_grace: float = 0.5  # time between the stop message and the kill
    # Time for a killed process to end: one that waits for a dead mount stays.
    kill_wait: float = 30.0
    message_interval: float = 1.0  # interval between two progress messages
    # Pause of a worker on which nothing works: others get its work.
    broken_worker_pause: float = 20.0

    # Closing an engine (service.execution).
    leave: float = 8.0  # time for attempts to write a checkpoint and end
    stop: float = 1.5  # time for stopped attempts to end

    # The engine on a Dask scheduler.
    connect: float = 5.0  # to reach the scheduler
    answer: float = 5.0  # limit for an answer of the scheduler or of a worker
    hang_up: float = 10.0  # time for a connection to close
    reconnect: float = 2.0  # interval between two tries to reach the scheduler
    connection_poll: float = 0.25  # interval between two checks of the connection
    result: float = 10.0  # time for an ending to arrive from its worker
    no_slot: float = 30.0  # without any worker, until waiting attempts count as lost


DEFAULT = Timings()
