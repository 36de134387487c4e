"""The exceptions of the project; the class carries the meaning.

::

    WhippleError
    +-- ProblemError       the input of a simulation contradicts itself or cannot be computed
    +-- UnphysicalState    a run left the range of its own physics: particle, time, quantity, value
    +-- RegistryError      a folder of models holds something that cannot be used
    +-- InvalidInput       (studies.quantities.findings) what a user gave is refused, with a cure for each finding

    Interrupted            a run stopped on request; not an error, hence outside the tree
"""


class WhippleError(Exception):
    """An error that the project raises on purpose."""


class ProblemError(WhippleError):
    """The input of a simulation contradicts itself or cannot be computed."""


class RegistryError(WhippleError):
    """A folder of models holds something that cannot be used."""


class UnphysicalState(WhippleError):
    """A run left the range of its own physics.

    Attributes: ``particle`` (its permanent number), ``body``, ``time`` (s), ``step``, ``quantity`` and its ``value``.
    """

    def __init__(self, *, particle: int, body: str, time: float, step: int, quantity: str, value: float):
        super().__init__(f"{quantity} = {value:.6g} at particle {particle} of {body!r}, t = {time:.6g} s, step {step}")
        self.particle = particle
        self.body = body
        self.time = time
        self.step = step
        self.quantity = quantity
        self.value = value


class Interrupted(Exception):
    """A run stopped on request after writing its checkpoint; the same call continues from there.

    Attributes: ``time`` (s) and ``step``.
    """

    def __init__(self, *, time: float, step: int):
        super().__init__(f"stopped at t = {time:.6g} s, step {step}")
        self.time = time
        self.step = step
