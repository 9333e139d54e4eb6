"""Tables of the apartment (paper, sections III-B and III-C, appendix C)."""

from __future__ import annotations

from ..storage.columns import FLOAT, INT, INTERVAL, TEST, TEXT, Column, Tables

CONDITION = (
    Column("robot", TEXT, "", "a key of apartment.robots"),
    Column("apartment", TEXT, "", "a key of apartment.scenes"),
    Column("start", TEXT, "", "anywhere, or within-reach: something is close to the arm"),
    Column("length", INT, "actions", "length of the sequences"),
)
VIEW = Column("field_of_view", FLOAT, "degrees", "vertical field of view of the camera")

APARTMENT: Tables = {
    "apartment_experiments": (
        *CONDITION,
        Column("dof", TEXT, "", "degree of freedom"),
        Column(
            "experiment",
            INT,
            "1",
            "number of the experiment; all degrees of freedom share its start situation",
        ),
        Column("seed", INT, "1", "seed of the experiment"),
        VIEW,
        Column(
            "touched_fixed",
            INT,
            "steps",
            "steps in which a fixture was touched, if only for a moment, in the order that had more",
        ),
        Column("touched_movable", INT, "steps", "the same of movable objects"),
        Column("touched_self", INT, "steps", "the same of the robot's own body"),
        Column(
            "at_limit",
            INT,
            "steps",
            "steps in which a joint was commanded beyond its limit, in the order that had more",
        ),
        Column(
            "object_shift",
            FLOAT,
            "m",
            "how far the object that moved most was displaced, in either order",
        ),
        Column("base_difference", FLOAT, "m", "distance of the two final places of the base"),
        Column("turn_difference", FLOAT, "rad", "difference of the two final headings"),
        Column(
            "joint_difference",
            FLOAT,
            "rad or m",
            "largest difference of a joint between the two ends",
        ),
        Column(
            "clearance",
            FLOAT,
            "m",
            "distance of the arm from the nearest thing at the start; 1 where it is more",
        ),
        Column(
            "distance",
            FLOAT,
            "squared VGG16 feature",
            "squared distance of the features of the two final observations",
        ),
    ),
    "apartment_scp": (
        *CONDITION,
        VIEW,
        Column("dof", TEXT, "", "degree of freedom"),
        Column(
            "threshold", FLOAT, "squared VGG16 feature", "largest distance that counts as equal"
        ),
        Column("n", INT, "1", "SC-experiments"),
        Column("commuted", INT, "1", "how many of them commuted"),
        Column("scp", FLOAT, "1", "sensory commutativity probability"),
        *INTERVAL,
    ),
    "apartment_hierarchy": (
        *CONDITION,
        VIEW,
        Column(
            "threshold", FLOAT, "squared VGG16 feature", "largest distance that counts as equal"
        ),
        Column("lower", TEXT, "", "group of degrees of freedom that should have the lower SCP"),
        Column("higher", TEXT, "", "group that should have the higher one"),
        Column("n", INT, "1", "start situations"),
        Column("scp_lower", FLOAT, "1", "mean SCP of the one group"),
        Column("scp_higher", FLOAT, "1", "mean SCP of the other"),
        Column("difference", FLOAT, "1", "lower minus higher"),
        *INTERVAL,
        *TEST,
    ),
    "apartment_order": (
        Column("robot", TEXT, "", "a key of apartment.robots"),
        Column("changed", TEXT, "", "which setting differs from the reference"),
        Column("value", TEXT, "", "its value"),
        Column("n", INT, "1", "start situations"),
        Column(
            "tau",
            FLOAT,
            "1",
            "Kendall's tau-b between the SCPs of the degrees of freedom there and in the reference",
        ),
        *INTERVAL,
    ),
    "apartment_interaction": (
        *CONDITION,
        Column("dof", TEXT, "", "degree of freedom"),
        Column("n", INT, "1", "SC-experiments"),
        Column("scp", FLOAT, "1", "sensory commutativity probability at the reference threshold"),
        Column(
            "touched",
            FLOAT,
            "1",
            "fraction of experiments in which a fixture or an object was touched",
        ),
        *INTERVAL,
        Column("touched_fixed", FLOAT, "1", "fraction in which a fixture was touched"),
        Column("touched_movable", FLOAT, "1", "fraction in which an object was touched"),
        Column(
            "moved_object",
            FLOAT,
            "1",
            "fraction in which an object was displaced by more than a centimetre",
        ),
        Column(
            "hindered",
            FLOAT,
            "1",
            "fraction in which only the robot's own body or a joint's limit was in the way",
        ),
        Column("n_touched", INT, "1", "experiments with touch"),
        Column("commuted_touched", INT, "1", "how many of them commuted"),
        Column("n_hindered", INT, "1", "experiments hindered by the robot itself"),
        Column("commuted_hindered", INT, "1", "how many of them commuted"),
        Column("n_free", INT, "1", "all others"),
        Column("commuted_free", INT, "1", "how many of them commuted"),
    ),
}
