// Lines along which values on a grid cross a level.

/**
 * The lines through a grid of points at `xs` and `ys`, in px, along which `value(column, row)` crosses `level`, as a path: marching squares with
 * straight interpolation. Squares with an unknown corner have no line.
 */
function contourPath(xs, ys, value, level) {
  let path = "";
  const between = (a, b, from, to) => from + ((b - a === 0 ? 0.5 : (level - a) / (b - a)) * (to - from));
  for (let row = 1; row < ys.length; row++) {
    for (let column = 1; column < xs.length; column++) {
      const [x0, x1, y0, y1] = [xs[column - 1], xs[column], ys[row - 1], ys[row]];
      const corners = [value(column - 1, row - 1), value(column, row - 1), value(column, row), value(column - 1, row)];
      if (corners.some((corner) => corner === null)) continue;
      const [a, b, c, d] = corners;
      const sides = [
        { crossed: a > level !== b > level, at: () => [between(a, b, x0, x1), y0] },
        { crossed: b > level !== c > level, at: () => [x1, between(b, c, y0, y1)] },
        { crossed: c > level !== d > level, at: () => [between(d, c, x0, x1), y1] },
        { crossed: d > level !== a > level, at: () => [x0, between(a, d, y0, y1)] },
      ].filter((side) => side.crossed).map((side) => side.at());
      // Two opposite corners above: divided as the mean of all four says.
      const turned = sides.length === 4 && a > level !== (a + b + c + d) / 4 > level;
      const order = turned ? [sides[3], sides[0], sides[1], sides[2]] : sides;
      for (let at = 0; at + 1 < order.length; at += 2) path += `M${order[at].join(",")}L${order[at + 1].join(",")}`;
    }
  }
  return path;
}
