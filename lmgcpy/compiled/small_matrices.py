"""Products and solutions of d x d matrices that are tuples of tuples, written out number by number, for d = 2, 3 and 6.

In a loop over an array that a kernel also writes to, the compiler fetches every number from memory again; tuples stay in
registers. (A block-tridiagonal elimination with blocks of 3 x 3 takes less than half the time.) The functions are made from
text, as :func:`lmgcpy.compiled.kernel.row_reader` is: loops would not give the compiler the lengths of the tuples.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache


@cache
def small_matrices(d: int) -> dict[str, Callable]:
    """The functions by name.

    ``block(m, i)``: matrix i of an array (n, d, d); ``row(m, i, at)`` and ``square(m, i, at)``: the vector, and the matrix,
    in row i of an array from column ``at`` on; ``store_row(m, i, v)``, ``store_square(m, i, at, A)``: into it;
    ``add_row(m, i, v)``: added to it; ``unit(x)``: the identity with 1 + x in its first place; ``transposed(A)``;
    ``negative(v)``; ``scaled(v, A)``: rows of A times the numbers v; ``product(A, B)``; ``times(A, v)``; ``plus(A, B)``,
    ``less(A, B)``, ``plus_row(v, w)``, ``less_row(v, w)``, ``scaled_row(v, w)``: sums, differences, and products number by
    number; ``inverted(A)``: ``(A^-1, |det A|)``, for d up to 3; ``multiple(x)``: ``x I``; ``multiple_row(x, v)``: ``x v``;
    ``first_only(x)``: the vector with x in its first place and zeros; ``dot(v, w)``; ``squares(v)``: ``v . v``;
    ``mean(v)``; ``differ(v, w)``: whether v and w differ in a number; ``exactly(v)``: v, written so that the compiler sees
    that it has d numbers.
    """
    R = range(d)
    answers = {
        "block(m, i)": _matrix("m[i, {i}, {j}]", d),
        "row(m, i, at)": _vector("m[i, at + {i}]", d),
        "square(m, i, at)": _matrix(f"m[i, at + {d} * {{i}} + {{j}}]", d),
        "unit(x)": "(" + "".join("(" + "".join(_unit(i, j) for j in R) + "), " for i in R) + ")",
        "transposed(A)": _matrix("A[{j}][{i}]", d),
        "negative(v)": _vector("-v[{i}]", d),
        "scaled(v, A)": _matrix("v[{i}] * A[{i}][{j}]", d),
        "product(A, B)": _matrix(" + ".join(f"A[{{i}}][{k}] * B[{k}][{{j}}]" for k in R), d),
        "times(A, v)": _vector(" + ".join(f"A[{{i}}][{k}] * v[{k}]" for k in R), d),
        "plus(A, B)": _matrix("A[{i}][{j}] + B[{i}][{j}]", d),
        "less(A, B)": _matrix("A[{i}][{j}] - B[{i}][{j}]", d),
        "plus_row(v, w)": _vector("v[{i}] + w[{i}]", d),
        "less_row(v, w)": _vector("v[{i}] - w[{i}]", d),
        "scaled_row(v, w)": _vector("v[{i}] * w[{i}]", d),
        "multiple(x)": "(" + "".join("(" + "".join("x, " if i == j else "0.0, " for j in R) + "), " for i in R) + ")",
        "multiple_row(x, v)": _vector("x * v[{i}]", d),
        "first_only(x)": "(x, " + "0.0, " * (d - 1) + ")",
        "dot(v, w)": " + ".join(f"v[{i}] * w[{i}]" for i in R),
        "squares(v)": " + ".join(f"v[{i}] ** 2" for i in R),
        "mean(v)": "(" + " + ".join(f"v[{i}]" for i in R) + f") / {d}.0",
        "differ(v, w)": " or ".join(f"v[{i}] != w[{i}]" for i in R),
    }
    bodies = {head: [f"return {answer}"] for head, answer in answers.items()}
    numbers = ", ".join(f"v{i}" for i in R)
    bodies["exactly(v)"] = [f"{numbers} = v", f"return {numbers}"]
    bodies["store_row(m, i, v)"] = [f"m[i, {a}] = v[{a}]" for a in R]
    bodies["store_square(m, i, at, A)"] = [f"m[i, at + {d * a + b}] = A[{a}][{b}]" for a in R for b in R]
    bodies["add_row(m, i, v)"] = [f"m[i, {a}] += v[{a}]" for a in R]
    if d <= 3:
        bodies["inverted(A)"] = _by_cofactors(d)
    made: dict[str, Callable] = {}
    exec("\n".join(f"def {head}:\n    " + "\n    ".join(body) for head, body in bodies.items()), {}, made)
    return made


def _vector(entry: str, d: int) -> str:
    return "(" + "".join(entry.format(i=i) + ", " for i in range(d)) + ")"


def _matrix(entry: str, d: int) -> str:
    rows = ("".join(entry.format(i=i, j=j) + ", " for j in range(d)) for i in range(d))
    return "(" + "".join(f"({row}), " for row in rows) + ")"


def _unit(i: int, j: int) -> str:
    return "1.0 + x, " if i == j == 0 else f"{float(i == j)}, "


def _by_cofactors(d: int) -> list[str]:
    """Lines of ``inverted``: the inverse from the cofactors. It waits for one division, elimination for d."""
    R = range(d)
    body = []
    for i in R:
        for j in R:
            p, *q = (k for k in R if k != i)
            x, *y = (k for k in R if k != j)
            minor = f"A[{p}][{x}] * A[{q[0]}][{y[0]}] - A[{p}][{y[0]}] * A[{q[0]}][{x}]" if q else f"A[{p}][{x}]"
            body.append(f"c{i}{j} = {'-' if (i + j) % 2 else ''}({minor})")
    body.append("determinant = " + " + ".join(f"A[0][{j}] * c0{j}" for j in R))
    body.append("inverse = 1.0 / determinant")
    body.append(f"return {_matrix('c{j}{i} * inverse', d)}, abs(determinant)")
    return body
