"""The matrices of a convex quadratic MathematicalProgram, read again quickly when its numbers change."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.solvers import Binding, MathematicalProgram
from scipy.sparse import csc_matrix

from a2s_drake.common.arrays import FloatArray


class QuadraticForm:
    """A program as min x'Px/2 + c'x subject to A x = b, h_l <= G x <= h_u, x_l <= x <= x_u.

    x are the program's decision variables in its own order. P, A and G are SciPy CSC matrices whose sparsity is that of
    the program when it was first read; P is the upper triangle alone.
    """

    def __init__(self, prog: MathematicalProgram) -> None:
        self._num_vars = prog.num_vars()
        self._evaluators = _evaluators(prog)
        self._quadratic = _Costs(prog, prog.quadratic_costs())
        self._linear = _Costs(prog, prog.linear_costs())
        self._equalities = _Rows(prog, prog.linear_equality_constraints())
        self._inequalities = _Rows(prog, prog.linear_constraints())
        self._boxes = [(binding.evaluator(), _indices(prog, binding)) for binding in prog.bounding_box_constraints()]
        self._box_bounds: list[FloatArray] = []
        self._hessians = [evaluator.Q() for evaluator in self._quadratic.evaluators]
        self.P = self._quadratic.upper_hessian(self._hessians, self._num_vars)
        self.A, self.G = self._equalities.matrix, self._inequalities.matrix
        self._read()

    def refresh(self, prog: MathematicalProgram) -> bool:
        """Reads the numbers again.

        Returns:
          False when more has changed than linear costs, bounds and coefficients within their sparsity; the form is
          then of no further use.
        """
        same_bindings = prog.num_vars() == self._num_vars and _same(_evaluators(prog), self._evaluators)
        return same_bindings and self._same_hessians() and self._read()

    def _same_hessians(self) -> bool:
        pairs = zip(self._quadratic.evaluators, self._hessians, strict=True)
        return all(np.array_equal(evaluator.Q(), known) for evaluator, known in pairs)

    def _read(self) -> bool:
        self.c = np.zeros(self._num_vars)
        self._quadratic.add_slopes(self.c, lambda cost: cost.b())
        self._linear.add_slopes(self.c, lambda cost: cost.a())
        self._read_boxes()
        self.b = self._equalities.bounds(lambda rows: rows.lower_bound())
        self.h_l = self._inequalities.bounds(lambda rows: rows.lower_bound())
        self.h_u = self._inequalities.bounds(lambda rows: rows.upper_bound())
        return self._equalities.refill() and self._inequalities.refill()

    def _read_boxes(self) -> None:
        bounds = [side for box, _ in self._boxes for side in (box.lower_bound(), box.upper_bound())]
        if self._box_bounds and all(map(np.array_equal, bounds, self._box_bounds)):
            return
        self._box_bounds = bounds
        self.x_l, self.x_u = np.full(self._num_vars, -np.inf), np.full(self._num_vars, np.inf)
        for (_, indices), lower, upper in zip(self._boxes, bounds[::2], bounds[1::2], strict=True):
            np.maximum.at(self.x_l, indices, lower)  # One box may name a variable twice.
            np.minimum.at(self.x_u, indices, upper)


def _indices(prog: MathematicalProgram, binding: Binding) -> Any:
    return np.asarray(prog.FindDecisionVariableIndices(binding.variables()))


def _evaluators(prog: MathematicalProgram) -> list[Any]:
    groups = (
        prog.quadratic_costs(),
        prog.linear_costs(),
        prog.linear_equality_constraints(),
        prog.linear_constraints(),
        prog.bounding_box_constraints(),
    )
    return [binding.evaluator() for group in groups for binding in group]


def _same(some: Sequence[Any], others: Sequence[Any]) -> bool:
    return len(some) == len(others) and all(one is other for one, other in zip(some, others, strict=True))


class _Costs:
    """Costs grouped by evaluator: many bindings may share one, which is then read once."""

    def __init__(self, prog: MathematicalProgram, bindings: Sequence[Binding]) -> None:
        places: dict[int, tuple[Any, list[Any]]] = {}
        for binding in bindings:
            evaluator = binding.evaluator()
            places.setdefault(id(evaluator), (evaluator, []))[1].append(_indices(prog, binding))
        self.evaluators = [evaluator for evaluator, _ in places.values()]
        self._indices = [np.array(indices) for _, indices in places.values()]

    def add_slopes(self, total: FloatArray, slope: Any) -> None:
        for evaluator, indices in zip(self.evaluators, self._indices, strict=True):
            values = slope(evaluator)
            if values.any():
                # Not np.add.at(total, indices, values): NumPy 2.4 reads past `values` instead of broadcasting it.
                total += np.bincount(indices.ravel(), np.tile(values, len(indices)), total.size)

    def upper_hessian(self, hessians: Sequence[FloatArray], num_vars: int) -> Any:
        rows, columns, values = [np.empty(0, int)], [np.empty(0, int)], [np.empty(0)]
        for hessian, indices in zip(hessians, self._indices, strict=True):
            i, j = np.nonzero(hessian)
            upper = indices[:, i] <= indices[:, j]
            rows.append(indices[:, i][upper])
            columns.append(indices[:, j][upper])
            values.append(np.broadcast_to(hessian[i, j], upper.shape)[upper])
        total = _SparseSum(np.concatenate(rows), np.concatenate(columns), (num_vars, num_vars))
        total.refill(np.concatenate(values))
        return total.matrix


class _Rows:
    """All linear constraints of one kind, one below the other."""

    def __init__(self, prog: MathematicalProgram, bindings: Sequence[Binding]) -> None:
        self._evaluators = [binding.evaluator() for binding in bindings]
        matrices = [evaluator.get_sparse_A() for evaluator in self._evaluators]
        self._patterns = [(matrix.indices, matrix.indptr) for matrix in matrices]
        rows, columns, height = [np.empty(0, int)], [np.empty(0, int)], 0
        for binding, matrix in zip(bindings, matrices, strict=True):
            rows.append(height + matrix.indices)
            columns.append(np.repeat(_indices(prog, binding), np.diff(matrix.indptr)))
            height += matrix.shape[0]
        self._sum = _SparseSum(np.concatenate(rows), np.concatenate(columns), (height, prog.num_vars()))
        self.matrix = self._sum.matrix

    def bounds(self, side: Any) -> FloatArray:
        return np.concatenate([np.empty(0), *(side(evaluator) for evaluator in self._evaluators)])

    def refill(self) -> bool:
        """Takes over the present coefficients; False where one stands outside the sparsity."""
        values = [np.empty(0)]
        for evaluator, (indices, starts) in zip(self._evaluators, self._patterns, strict=True):
            matrix = evaluator.get_sparse_A()
            if not (np.array_equal(matrix.indices, indices) and np.array_equal(matrix.indptr, starts)):
                return False
            values.append(matrix.data)
        self._sum.refill(np.concatenate(values))
        return True


class _SparseSum:
    """A CSC matrix of fixed sparsity, refilled with the values of entries that may fall on one another."""

    def __init__(self, rows: Any, columns: Any, shape: tuple[int, int]) -> None:
        places, self._place_of_entry = np.unique(columns * shape[0] + rows, return_inverse=True)
        starts = np.searchsorted(places, np.arange(shape[1] + 1) * shape[0])
        self.matrix = csc_matrix((np.zeros(places.size), places % max(shape[0], 1), starts), shape)
        self._apart = places.size == len(self._place_of_entry)

    def refill(self, values: FloatArray) -> None:
        if self._apart:
            self.matrix.data[self._place_of_entry] = values
        else:
            self.matrix.data[:] = np.bincount(self._place_of_entry, values, self.matrix.nnz)
