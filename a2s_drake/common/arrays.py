"""Array types of the library's signatures."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Of float64, or an object array of Drake's AutoDiffXd.
Array = NDArray[Any]
