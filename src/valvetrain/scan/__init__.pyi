from valvetrain.scan.compare import ScanComparison as ScanComparison
from valvetrain.scan.compare import compare_scan as compare_scan
from valvetrain.scan.reconstruct import spring_from_scan as spring_from_scan
from valvetrain.scan.result import ScannedSpring as ScannedSpring
