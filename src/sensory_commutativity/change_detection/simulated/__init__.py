"""Pictures with ground truth from the apartment simulation.

:mod:`.pairs` makes labelled pairs to train on without playing experiments;
:mod:`.object_experiments` plays SC-experiments on objects to test on; :mod:`.local_scp` plays them
at the poses of :mod:`.poses` for a map of the local SCP, which :mod:`.reach` compares with what the
arm can reach.
"""
