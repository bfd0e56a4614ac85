from valvetrain.cosserat.batch import RodBatch as RodBatch
from valvetrain.cosserat.batch import simulate_batch as simulate_batch
