"""The paper's two alternatives to the SCP (appendix A): how much the sensors change, and how hard that is to predict."""
