# Types of the package. For documentation see help(enamel.NAME).
from os import PathLike
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

_File = Union[str, "PathLike[str]"]
_Floats = npt.NDArray[np.float64]
_Delay = Tuple[int, int]

data: Path
contact_dtype: "np.dtype[np.void]"
modes: Tuple[str, ...]
statuses: Tuple[str, ...]
guard_reasons: Tuple[str, ...]
verdicts: Tuple[str, ...]
plants: Sequence[str]

class Error(RuntimeError): ...
class PluginError(Error): ...
class DesignError(Error): ...

class ConfigurationError(Error):
    file: str
    line: int
    key: str

class Kinematics:
    @property
    def q(self) -> _Floats: ...
    @property
    def rates(self) -> _Floats: ...
    @property
    def position(self) -> _Floats: ...
    @property
    def rotation(self) -> _Floats: ...
    @property
    def twist(self) -> _Floats: ...
    @property
    def jacobian(self) -> _Floats: ...
    @property
    def inverse_transposed(self) -> _Floats: ...
    @property
    def gravity(self) -> _Floats: ...
    @property
    def inertia(self) -> _Floats: ...

class Device:
    def __init__(self, path: _File) -> None: ...
    @staticmethod
    def parse(text: str, file: str = ...) -> Device: ...
    @property
    def name(self) -> str: ...
    @property
    def joints(self) -> int: ...
    @property
    def max_torque(self) -> _Floats: ...
    @property
    def encoder_step(self) -> _Floats: ...
    @property
    def count(self) -> _Floats: ...
    @property
    def home(self) -> Kinematics: ...
    def track(self, q: npt.ArrayLike, rates: Optional[npt.ArrayLike] = ...) -> Kinematics: ...
    def reach(
        self, position: npt.ArrayLike, rotation: Optional[npt.ArrayLike] = ..., twist: Optional[npt.ArrayLike] = ...
    ) -> Kinematics: ...
    def accelerate(
        self,
        position: npt.ArrayLike,
        torque: npt.ArrayLike,
        rotation: Optional[npt.ArrayLike] = ...,
        twist: Optional[npt.ArrayLike] = ...,
        wrench: Optional[npt.ArrayLike] = ...,
    ) -> _Floats: ...
    def damped(self, damping: npt.ArrayLike) -> Device: ...
    def with_handpiece(
        self,
        mass: float,
        com: npt.ArrayLike = ...,
        inertia: Optional[npt.ArrayLike] = ...,
        gravity: npt.ArrayLike = ...,
    ) -> Device: ...

class Scene:
    def __init__(self, path: Optional[_File] = ...) -> None: ...
    start: Any
    @property
    def name(self) -> str: ...
    @property
    def notes(self) -> Sequence[str]: ...
    @property
    def obstacles(self) -> Sequence[str]: ...
    def set_tool(self, parts: Union[str, Sequence[Tuple[npt.ArrayLike, npt.ArrayLike, float]]]) -> None: ...
    def add_half_space(
        self,
        name: str,
        point: npt.ArrayLike = ...,
        normal: npt.ArrayLike = ...,
        stiffness: float = ...,
        friction: float = ...,
    ) -> int: ...
    def add_sphere(
        self, name: str, centre: npt.ArrayLike, radius: float, stiffness: float = ..., friction: float = ...
    ) -> int: ...
    def add_box(
        self,
        name: str,
        centre: npt.ArrayLike,
        size: npt.ArrayLike,
        rotation: Optional[npt.ArrayLike] = ...,
        stiffness: float = ...,
        friction: float = ...,
    ) -> int: ...
    def soften(
        self,
        obstacle: int,
        stiffness: float,
        exponent: float = ...,
        thickness: float = ...,
        hysteresis: float = ...,
        puncture: float = ...,
    ) -> None: ...
    def set_surface(
        self,
        obstacle: int,
        friction: float = ...,
        sliding_friction: Optional[float] = ...,
        stribeck_speed: float = ...,
        viscosity: float = ...,
        roughness: float = ...,
        wavelength: float = ...,
    ) -> None: ...
    def set_tap(self, obstacle: int, tap: Union[str, Tuple[float, float]]) -> None: ...
    def add_line_guide(
        self, points: npt.ArrayLike, stiffness: float, max_force: float, radius: float = ...
    ) -> None: ...
    def add_plane_guide(
        self,
        point: npt.ArrayLike,
        normal: npt.ArrayLike,
        stiffness: float,
        max_force: float,
        one_sided: bool = ...,
    ) -> None: ...
    def add_box_guide(
        self,
        centre: npt.ArrayLike,
        size: npt.ArrayLike,
        stiffness: float,
        max_force: float,
        rotation: Optional[npt.ArrayLike] = ...,
    ) -> None: ...
    def suspend(
        self,
        obstacle: int,
        inertia: npt.ArrayLike,
        stiffness: npt.ArrayLike = ...,
        damping: npt.ArrayLike = ...,
        centre: npt.ArrayLike = ...,
    ) -> None: ...
    def add_mesh(
        self,
        name: str,
        vertices: npt.ArrayLike,
        triangles: npt.ArrayLike,
        position: npt.ArrayLike = ...,
        rotation: Optional[npt.ArrayLike] = ...,
        stiffness: float = ...,
        friction: float = ...,
        thickness: float = ...,
    ) -> int: ...
    def add_labels(
        self,
        name: str,
        labels: npt.ArrayLike,
        layers: Sequence[Tuple[str, Sequence[int], float]],
        spacing: npt.ArrayLike,
        smoothing: Optional[float] = ...,
        cell: float = ...,
        position: npt.ArrayLike = ...,
        rotation: Optional[npt.ArrayLike] = ...,
    ) -> int: ...
    def add_solid(
        self, name: str, path: _File, position: npt.ArrayLike = ..., rotation: Optional[npt.ArrayLike] = ...
    ) -> int: ...
    def save_solid(self, obstacle: int, path: _File) -> None: ...
    def compare_cut(
        self, obstacle: int, vertices: npt.ArrayLike, triangles: npt.ArrayLike, axis: npt.ArrayLike = ...
    ) -> Mapping[str, Any]: ...
    def mesh(self, obstacle: int) -> Tuple[_Floats, npt.NDArray[np.int32]]: ...
    def describe(self, obstacle: int) -> str: ...
    def move(
        self,
        obstacle: int,
        position: npt.ArrayLike,
        rotation: Optional[npt.ArrayLike] = ...,
        twist: Optional[npt.ArrayLike] = ...,
    ) -> None: ...
    def contacts(
        self,
        positions: npt.ArrayLike,
        rotations: Optional[npt.ArrayLike] = ...,
        margin: float = ...,
        follow: bool = ...,
    ) -> npt.NDArray[np.void]: ...
    def nearest(
        self, positions: npt.ArrayLike, rotations: Optional[npt.ArrayLike] = ...
    ) -> npt.NDArray[np.void]: ...

def load_mesh(path: _File, scale: float = ...) -> Tuple[_Floats, npt.NDArray[np.int32]]: ...

class Tick:
    @property
    def time(self) -> float: ...
    @property
    def kinematics(self) -> Kinematics: ...
    @property
    def contacts(self) -> npt.NDArray[np.void]: ...
    @property
    def max_torque(self) -> _Floats: ...
    @property
    def age(self) -> int: ...
    @property
    def applied(self) -> _Floats: ...

class PythonRenderer:
    needs_inertia: bool
    def activate(self, period: float) -> None: ...
    def reset(self) -> None: ...
    def render(self, tick: Tick) -> npt.ArrayLike: ...

class Renderer:
    @property
    def name(self) -> str: ...

RendererLike = Union[Renderer, Callable[[], Union[Renderer, PythonRenderer]]]

def position_control(
    device: Device, period: float = ..., delay: _Delay = ..., plant: str = ...
) -> Renderer: ...
def hold(
    device: Device,
    period: float = ...,
    gain: Optional[npt.ArrayLike] = ...,
    release: bool = ...,
    anti_windup: bool = ...,
) -> Renderer: ...
def impedance(stiffness: float = ..., damping: float = ...) -> Renderer: ...
def passivity(stiffness: float = ..., damping: float = ..., memory: bool = ...) -> Renderer: ...
def virtual_coupling(stiffness: float = ..., damping: float = ..., mass: float = ...) -> Renderer: ...
def plugin(path: _File, device: Optional[_File] = ..., **parameters: object) -> Renderer: ...

class ServoDesign:
    @property
    def period(self) -> float: ...
    @property
    def K(self) -> _Floats: ...
    @property
    def P(self) -> _Floats: ...
    @property
    def A(self) -> _Floats: ...
    @property
    def B(self) -> _Floats: ...

def design_servo(
    device: Device,
    position: Optional[npt.ArrayLike] = ...,
    period: float = ...,
    velocity: float = ...,
    weight: float = ...,
    integral: float = ...,
    torque: float = ...,
) -> ServoDesign: ...
def load_servo(path: _File) -> _Floats: ...

class Push:
    @property
    def ticks(self) -> npt.NDArray[np.void]: ...
    @property
    def metrics(self) -> Mapping[str, Optional[float]]: ...
    @property
    def verdict(self) -> str: ...
    @property
    def stopped(self) -> Optional[str]: ...

def push(
    device: Device,
    renderer: RendererLike,
    *,
    scene: Optional[Scene] = ...,
    scenario: int = ...,
    force: float = ...,
    preload: float = ...,
    noise: float = ...,
    start: Optional[npt.ArrayLike] = ...,
    tip: Optional[npt.ArrayLike] = ...,
    guard: bool = ...,
    max_force: float = ...,
    guide: bool = ...,
    arm: bool = ...,
    finger_rest: bool = ...,
    delay: _Delay = ...,
    encoders: bool = ...,
    rates: str = ...,
    low_pass: float = ...,
    period: float = ...,
    substeps: int = ...,
    duration: float = ...,
    seed: int = ...,
    run: int = ...,
    inside_tick: bool = ...,
    plant: str = ...,
    model: Optional[Device] = ...,
) -> Push: ...

class Study:
    @property
    def runs(self) -> npt.NDArray[np.void]: ...
    @property
    def renderers(self) -> Sequence[str]: ...
    @property
    def walls(self) -> Sequence[Mapping[str, Any]]: ...
    def point(self, number: int) -> _Floats: ...

def study(
    device: Device,
    renderers: Mapping[str, Union[RendererLike, Tuple[RendererLike, Device]]],
    *,
    scenarios: Sequence[int] = ...,
    grid: int = ...,
    half_width: float = ...,
    runs: int = ...,
    lowest_force: float = ...,
    highest_force: float = ...,
    preload: float = ...,
    noise: float = ...,
    finger_rest: bool = ...,
    delay: _Delay = ...,
    encoders: bool = ...,
    guard: bool = ...,
    period: float = ...,
    seed: int = ...,
    inside_tick: bool = ...,
    plant: str = ...,
    threads: int = ...,
) -> Study: ...
def judge(
    device: Device,
    renderer: RendererLike,
    *,
    runs: int = ...,
    delay: _Delay = ...,
    inertia_error: float = ...,
    period: float = ...,
    seed: int = ...,
    threads: int = ...,
) -> Mapping[str, Any]: ...
def trials(
    device: Device,
    renderer: RendererLike,
    *,
    filter: str = ...,
    runs: int = ...,
    delay: _Delay = ...,
    noise: float = ...,
    period: float = ...,
    seed: int = ...,
    model: Optional[Device] = ...,
    threads: int = ...,
) -> Sequence[Mapping[str, Any]]: ...

class Recording:
    def __init__(self, path: _File) -> None: ...
    @property
    def device(self) -> Device: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def renderer(self) -> str: ...
    @property
    def parameters(self) -> Mapping[str, str]: ...
    @property
    def period(self) -> float: ...
    def ticks(self) -> npt.NDArray[np.void]: ...
    def replay(self, renderer: RendererLike) -> Mapping[str, Any]: ...
