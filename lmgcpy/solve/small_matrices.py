"""Products and solutions of d x d matrices that are tuples of tuples, written out number by number for d = 2 and 3.

In a loop over an array that a kernel also writes to, the compiler has to fetch every number from memory again; tuples stay
in registers. (A block-tridiagonal elimination with blocks of 3 x 3 takes a third of the time.) The functions are made from
text, as :func:`lmgcpy.jit.row_reader` is, since their lengths are known to the compiler only so.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

NAMES = (
    *(
        "block",
        "row",
        "square",
        "store_row",
        "store_square",
        "unit",
        "transposed",
        "negative",
        "scaled",
        "product",
        "times",
    ),
    *("plus", "less", "plus_row", "less_row", "solve"),
)


@cache
def small_matrices(d: int) -> dict[str, Callable]:
    """The functions by name.

    ``block(m, i)``: matrix i of an array (n, d, d); ``row(m, i, at)`` and ``square(m, i, at)``: the vector, and the matrix,
    that stand in row i of an array from column ``at`` on; ``store_row(m, i, v)``, ``store_square(m, i, at, A)``: into it;
    ``unit(x)``: the identity with 1 + x in its first place; ``transposed(A)``; ``negative(v)``; ``scaled(v, A)``: rows of A
    times the numbers v; ``product(A, B)``; ``times(A, v)``; ``plus(A, B)``, ``less(A, B)``, ``plus_row(v, w)``, ``less_row(v, w)``:
    sums and differences; ``solve(A, B, v)``: ``(A^-1 B, A^-1 v, |det A|)``.
    """
    R = range(d)

    def matrix(entry: Callable[[int, int], str]) -> str:
        return "(" + "".join("(" + "".join(f"{entry(i, j)}, " for j in R) + "), " for i in R) + ")"

    def vector(entry: Callable[[int], str]) -> str:
        return "(" + "".join(f"{entry(i)}, " for i in R) + ")"

    def lines(name: str, arguments: str, body: list[str]) -> str:
        return f"def {name}({arguments}):\n" + "".join(f"    {line}\n" for line in body)

    def over(i: int, j: int) -> str:
        return " + ".join(f"A[{i}][{k}] * B[{k}][{j}]" for k in R)

    texts = [
        lines("block", "m, i", [f"return {matrix(lambda a, b: f'm[i, {a}, {b}]')}"]),
        lines("row", "m, i, at", [f"return {vector(lambda a: f'm[i, at + {a}]')}"]),
        lines("square", "m, i, at", [f"return {matrix(lambda a, b: f'm[i, at + {d * a + b}]')}"]),
        lines("store_row", "m, i, v", [f"m[i, {a}] = v[{a}]" for a in R]),
        lines("store_square", "m, i, at, A", [f"m[i, at + {d * a + b}] = A[{a}][{b}]" for a in R for b in R]),
        lines("unit", "x", [f"return {matrix(lambda i, j: '1.0 + x' if i == j == 0 else str(float(i == j)))}"]),
        lines("negative", "v", [f"return {vector(lambda i: f'-v[{i}]')}"]),
        lines("transposed", "A", [f"return {matrix(lambda i, j: f'A[{j}][{i}]')}"]),
        lines("scaled", "v, A", [f"return {matrix(lambda i, j: f'v[{i}] * A[{i}][{j}]')}"]),
        lines("product", "A, B", [f"return {matrix(over)}"]),
        lines("times", "A, v", [f"return {vector(lambda i: ' + '.join(f'A[{i}][{k}] * v[{k}]' for k in R))}"]),
        *(
            text
            for name, sign in (("plus", "+"), ("less", "-"))
            for text in (
                lines(name, "A, B", [f"return {matrix(lambda i, j, sign=sign: f'A[{i}][{j}] {sign} B[{i}][{j}]')}"]),
                lines(f"{name}_row", "v, w", [f"return {vector(lambda i, sign=sign: f'v[{i}] {sign} w[{i}]')}"]),
            )
        ),
        lines("solve", "A, B, v", cofactors(d)),
    ]
    names: dict = {}
    exec("\n".join(texts), names)  # texts of this function alone
    return {name: names[name] for name in NAMES}


def cofactors(d: int) -> list[str]:
    """The lines of ``solve``: the inverse from the cofactors (one division, where elimination waits for d of them)."""
    R = range(d)
    body = []
    for i in R:
        for j in R:
            rows, columns = [k for k in R if k != i], [k for k in R if k != j]
            if d == 2:
                minor = f"A[{rows[0]}][{columns[0]}]"
            else:
                (p, q), (x, y) = rows, columns
                minor = f"A[{p}][{x}] * A[{q}][{y}] - A[{p}][{y}] * A[{q}][{x}]"
            body.append(f"c{i}{j} = {'-' if (i + j) % 2 else ''}({minor})")
    body.append("determinant = " + " + ".join(f"A[0][{j}] * c0{j}" for j in R))
    body.append("inverse = 1.0 / determinant")
    body += [f"i{j}{i} = c{i}{j} * inverse" for i in R for j in R]
    rows = ", ".join("(" + ", ".join(" + ".join(f"i{i}{k} * B[{k}][{j}]" for k in R) for j in R) + ")" for i in R)
    body.append(f"return ({rows}), ({', '.join(' + '.join(f'i{i}{k} * v[{k}]' for k in R) for i in R)}), abs(determinant)")
    return body
