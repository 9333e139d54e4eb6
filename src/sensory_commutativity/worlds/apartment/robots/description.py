"""The YAML file that describes a robot: its keys and what they mean.

``config/robots/`` contains two examples.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ....storage.settings import Name, Section

Triple = Annotated[list[float], Field(min_length=3, max_length=3)]
Range = Annotated[list[float], Field(min_length=2, max_length=2)]
Pair = Annotated[list[str], Field(min_length=2, max_length=2)]


class DofDescription(Section):
    """A degree of freedom: one dimension of the action space."""

    name: Name = Field(description="Name in tables and figures.")
    joints: list[str] = Field(
        min_length=1,
        description="Joints of the URDF that move together. Joints that mimic one of them follow "
        "it, listed or not.",
    )
    ratio: dict[str, float] = Field(
        default_factory=dict,
        description="How far joints move for each unit that the degree of freedom moves; default: "
        "1, or the multiplier of <mimic>.",
    )
    unit: Literal["rad", "m"] = Field(
        description="rad for revolute joints, m for prismatic ones; must match the URDF."
    )
    velocity: float = Field(
        gt=0, description="Velocity that an action of 1 commands, in the unit per second."
    )
    group: Name = Field(
        description="Kind of joint, for averages: wheel, torso, shoulder, elbow, wrist, ..."
    )
    force: float | None = Field(
        None,
        gt=0,
        description="Maximum force of the motors, Nm or N; default: arm_force, or lift_force for "
        "prismatic joints.",
    )


class DriveDescription(Section):
    """A differential drive: two independent wheels. A positive action turns a wheel forwards."""

    right_wheel: str = Field(description="Joint of the right wheel (at negative y).")
    left_wheel: str = Field(description="Joint of the left wheel.")
    wheel_radius: float | None = Field(
        None, gt=0, description="Metres; default: that of the wheel's shape in the URDF."
    )
    track: float | None = Field(
        None, gt=0,
        description="Distance between the wheels, metres; default: that of the URDF.",
    )  # fmt: skip
    axle: float | None = Field(
        None,
        description="Where the robot turns, along the x axis of the root link, metres; default: "
        "the middle of the two wheels. For robots with four wheels: the middle of all.",
    )
    # Measured: these follow a ramp to 1 m/s, and to 6 rad/s, with a robot of 115 kg.
    force: float = Field(1500.0, gt=0, description="Maximum force on the base, N.")
    torque: float = Field(700.0, gt=0, description="Maximum torque on the base, Nm.")


class CameraDescription(Section):
    """Where the camera is mounted. It looks along its own x axis; y is left, z is up."""

    link: str = Field(description="Link of the URDF that carries it.")
    position: Triple = Field(description="Metres, in the link's frame.")
    rotation: Triple = Field(
        [0.0, 0.0, 0.0],
        description="Roll, pitch and yaw in the link's frame, rad; a positive pitch looks down.",
    )
    field_of_view: float = Field(
        90.0,
        ge=5,
        le=150,
        description="Vertical, degrees; the configuration of the apartment may override it.",
    )


class RobotDescription(Section):
    """A robot. Its axes are those of ROS: x forward, y left, z up."""

    name: Name
    about: str = Field("", description="Origin of the model, its licence, its approximations.")
    urdf: str = Field(
        min_length=1,
        description="A path relative to this file, or package://NAME/PATH of an installed Python "
        "package.",
    )
    dofs: list[DofDescription] = Field(
        min_length=1, description="Degrees of freedom, in the order of the action vector."
    )
    drive: DriveDescription | None = Field(
        None, description="How wheels move the base; without it the base is fixed to the floor."
    )
    camera: CameraDescription
    height: float | None = Field(
        None,
        description="Metres from the floor to the root link; default: the wheels touch the floor, "
        "or 0 without wheels.",
    )
    fixed: dict[str, float] = Field(
        default_factory=dict,
        description="Positions of joints outside the degrees of freedom; 0 if not listed.",
    )
    start: dict[str, Range] = Field(
        default_factory=dict,
        description="Lowest and highest start position of joints of degrees of freedom; 0 if not "
        "listed.",
    )
    # Measured: with less, joints lag behind their commands.
    arm_force: float = Field(
        1000.0, gt=0, description="Maximum torque of the motors of revolute joints, Nm."
    )
    # Measured: enough for the torso of Fetch, which lifts 40 kg.
    lift_force: float = Field(
        5000.0, gt=0, description="Maximum force of the motors of prismatic joints, N."
    )
    passing: list[Pair] = Field(
        default_factory=list,
        description="Pairs of links that do not collide, besides those that share a joint.",
    )
    hierarchy: list[Name] = Field(
        default_factory=list,
        description="Groups of degrees of freedom from the lowest expected SCP to the highest; "
        "tested if there are at least two.",
    )
    faces_per_mesh: int = Field(
        160, ge=4, le=100_000, description="Maximum triangles of each mesh that the camera renders."
    )
