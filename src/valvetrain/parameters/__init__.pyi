from valvetrain.parameters.curves import Constant as Constant
from valvetrain.parameters.curves import PiecewiseLinear as PiecewiseLinear
from valvetrain.parameters.curves import Table as Table
from valvetrain.parameters.installed_spring import Guide as Guide
from valvetrain.parameters.material import Material as Material
from valvetrain.parameters.spring import SpringDefinition as SpringDefinition
from valvetrain.parameters.winding import EndCoil as EndCoil
