from valvetrain.explore.distributions import Prior as Prior
from valvetrain.explore.identification_file import Search as Search
from valvetrain.explore.identified import Identified as Identified
from valvetrain.explore.optimum import Optimum as Optimum
from valvetrain.explore.posterior import Datum as Datum
from valvetrain.explore.table import StudyTable as StudyTable
