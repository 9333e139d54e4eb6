"""Tables of Flatland (paper, section III-A, appendices A and B)."""

from __future__ import annotations

from ..storage.columns import FLOAT, INT, INTERVAL, SCP, TEST, TEXT, WHERE, Column, Tables

FLATLAND: Tables = {
    "flatland_experiments": (
        *WHERE,
        Column("length", INT, "actions", "length of the sequences"),
        Column("dof", TEXT, "", "degree of freedom"),
        Column(
            "experiment",
            INT,
            "1",
            "number of the experiment; all degrees of freedom share its start situation",
        ),
        Column("seed", INT, "1", "seed of the experiment"),
        Column(
            "distance",
            FLOAT,
            "squared 8-bit colour",
            "mean squared error of the two final observations",
        ),
    ),
    "flatland_scp": SCP,
    "flatland_sensitivity": SCP,
    "flatland_comparisons": (
        *WHERE,
        Column("dof_a", TEXT, "", "degree of freedom"),
        Column("dof_b", TEXT, "", "degree of freedom"),
        Column("test", TEXT, "", "name of the test"),
        Column("n", INT, "1", "start situations that both were tried in"),
        Column("only_a", INT, "1", "situations in which only a commuted"),
        Column("only_b", INT, "1", "situations in which only b commuted"),
        Column("difference", FLOAT, "1", "SCP of a minus SCP of b"),
        *INTERVAL,
        *TEST,
    ),
    "flatland_trends": (
        Column("trend", TEXT, "", "objects or arm length"),
        Column("stratum", TEXT, "", "the agent, for objects; all worlds, for arm length"),
        Column("dof", TEXT, "", "degree of freedom"),
        Column("test", TEXT, "", "name of the test"),
        Column("statistic", FLOAT, "1", "z of the trend, or the pooled odds ratio"),
        Column(
            "effect", FLOAT, "1", "change of SCP per object, or from the shorter to the longer arms"
        ),
        *TEST,
    ),
    "flatland_commutation_experiments": (
        WHERE[0],
        Column("dof_a", TEXT, "", "degree of freedom"),
        Column("dof_b", TEXT, "", "degree of freedom"),
        Column(
            "experiment", INT, "1", "number of the experiment; all pairs share its start situation"
        ),
        Column("seed", INT, "1", "seed of the experiment"),
        Column(
            "distance",
            FLOAT,
            "squared 8-bit colour",
            "mean squared error of the two final observations",
        ),
    ),
    "flatland_commutation": (
        WHERE[0],
        Column("dof_a", TEXT, "", "degree of freedom"),
        Column("dof_b", TEXT, "", "degree of freedom"),
        Column("n", INT, "1", "experiments"),
        Column("commuted", INT, "1", "how many of them commuted"),
        Column("probability", FLOAT, "1", "probability that a then b and b then a end equal"),
        *INTERVAL,
    ),
    "flatland_baselines": (
        Column("dof", TEXT, "", "degree of freedom"),
        Column(
            "naive_mse",
            FLOAT,
            "squared 8-bit colour",
            "mean squared change of the observation in a transition",
        ),
        Column(
            "naive_se",
            FLOAT,
            "squared 8-bit colour",
            "standard error of naive_mse, sequences as units",
        ),
        Column(
            "prediction_mse",
            FLOAT,
            "squared 8-bit colour",
            "mean squared error of the predicted next observation, test transitions",
        ),
        Column(
            "prediction_se",
            FLOAT,
            "squared 8-bit colour",
            "standard error of prediction_mse, sequences as units",
        ),
        Column(
            "excess_error",
            FLOAT,
            "squared 8-bit colour",
            "prediction_mse less the smallest of all degrees of freedom",
        ),
        Column("n_transitions", INT, "1", "transitions"),
        Column("n_test", INT, "1", "transitions that tested the prediction"),
    ),
    "flatland_alternatives": (
        Column("alternative", TEXT, "", "naive change or excess prediction error"),
        Column("n", INT, "1", "degrees of freedom"),
        Column(
            "spearman",
            FLOAT,
            "1",
            "Spearman's rank correlation with 1 - SCP; 1 would be the same order",
        ),
        Column("kendall", FLOAT, "1", "Kendall's tau-b with 1 - SCP"),
        Column("p", FLOAT, "1", "two-sided p-value of Spearman's coefficient, permutation test"),
    ),
}
