from valvetrain.runs.branch_march import branches as branches
from valvetrain.runs.cluster import on_cluster as on_cluster
from valvetrain.runs.train_runs import train_modes as train_modes
