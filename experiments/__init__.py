"""Tables, figures and studies, each runnable as ``python -m experiments.NAME``."""

import sdh_sim  # noqa: F401 - it looks at MUJOCO_GL, which must be before MuJoCo is imported
