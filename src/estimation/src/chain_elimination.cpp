// SPDX-License-Identifier: Apache-2.0
#include "chain_elimination.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {
namespace {

/// Pivots below this part of their diagonal are rounding.
constexpr double kLeastPivot = 1e-13;

/// to += factor * from, `count` numbers each.
inline void add(double* __restrict to, double factor, const double* __restrict from, int count) {
  for (int i = 0; i < count; ++i) {
    to[i] += factor * from[i];
  }
}

/// Square matrices by rows, `stride` numbers apart; of symmetric ones the upper triangle is read.
struct Rows {
  double* data;
  int stride;
  [[nodiscard]] double* row(int i) const { return data + i * stride; }
};

/// The root U of a = U^T U in its place, and the inverses of its diagonal. False when it has none.
bool factorise_rows(const Rows& a, int size, double* inverse_diagonal) {
  for (int k = 0; k < size; ++k) {
    inverse_diagonal[k] = a.row(k)[k];
  }
  for (int k = 0; k < size; ++k) {
    double* const row = a.row(k);
    const double pivot = row[k];
    if (!(pivot > kLeastPivot * inverse_diagonal[k]) || !std::isfinite(pivot)) {
      return false;
    }
    const double scale = 1 / std::sqrt(pivot);
    inverse_diagonal[k] = scale;
    for (int j = k; j < size; ++j) {
      row[j] *= scale;
    }
    for (int i = k + 1; i < size; ++i) {
      add(a.row(i) + i, -row[i], row + i, size - i);
    }
  }
  return true;
}

/// U^-T x in place; x has `columns` columns.
void forward(const Rows& root, const double* inverse_diagonal, int size, const Rows& x,
             int columns) {
  for (int i = 0; i < size; ++i) {
    double* const row = x.row(i);
    for (int c = 0; c < columns; ++c) {
      row[c] *= inverse_diagonal[i];
    }
    for (int j = i + 1; j < size; ++j) {
      add(x.row(j), -root.row(i)[j], row, columns);
    }
  }
}

Rows rows_of(Block& block) {
  return {block.data(), kStateSize};
}

/// Information about a state without its link to the next.
struct Unlinked {
  Block h;
  Border border;
  StateVector b;
};

Unlinked unlinked(const Clique& clique, const Message& in, const Damping& damping) {
  Unlinked m{
      .h = clique.own.h + in.h, .border = clique.own.border + in.border, .b = clique.own.b + in.b};
  if (damping.factor > 0) {
    const StateVector added = damping.factor * (m.h.diagonal() + clique.link_h.diagonal());
    m.h.diagonal() += added;
    m.b += added.cwiseProduct(damping.centre);
  }
  return m;
}

bool factorise_state(const Block& h, Eliminated& eliminated) {
  eliminated.root = h;
  if (!factorise_rows(rows_of(eliminated.root), kStateSize, eliminated.inverse_diagonal.data())) {
    return false;
  }
  solve_root(eliminated, eliminated.y);
  solve_root(eliminated, eliminated.border);
  return true;
}

/// What a state without its link says through the rows of the link, to the next and the globals.
bool pass_on(const Clique& clique, const Message& in, Unlinked& m, Message& out) {
  constexpr int kMost = Clique::kMaxRows;
  constexpr int kColumns = kMost + 1 + kGlobalSize;
  const int rows = clique.rows;
  const auto globals = static_cast<int>(m.border.cols());

  // U_m^-T [F_i^T, b, border]
  double inverse[kMost];
  const Rows root = rows_of(m.h);
  if (!factorise_rows(root, kStateSize, inverse)) {
    return false;
  }
  double z_data[kStateSize * kColumns];
  const Rows z{z_data, kColumns};
  for (int i = 0; i < kStateSize; ++i) {
    double* const row = z.row(i);
    for (int r = 0; r < rows; ++r) {
      row[r] = clique.from(r, i);
    }
    row[rows] = m.b[i];
    for (int g = 0; g < globals; ++g) {
      row[rows + 1 + g] = m.border(i, g);
    }
  }
  forward(root, inverse, kStateSize, z, rows + 1 + globals);

  // S = 1 + F_i M^-1 F_i^T, and the rows as they are once the state is gone: [F_j, r, F_g].
  constexpr int kRight = kStateSize + 1 + kGlobalSize;
  double s_data[kMost * kMost];
  double v_data[kMost * kRight];
  const Rows s{s_data, kMost};
  const Rows v{v_data, kRight};
  for (int r = 0; r < rows; ++r) {
    std::fill(s.row(r), s.row(r) + rows, 0.0);
    s.row(r)[r] = 1;
    std::copy_n(clique.to.data() + r * kStateSize, kStateSize, v.row(r));
    v.row(r)[kStateSize] = clique.residual[r];
    std::copy_n(clique.globals.data() + r * kGlobalSize, globals, v.row(r) + kStateSize + 1);
  }
  for (int i = 0; i < kStateSize; ++i) {
    const double* const row = z.row(i);
    for (int r = 0; r < rows; ++r) {
      add(s.row(r) + r, row[r], row + r, rows - r);
      v.row(r)[kStateSize] += row[r] * row[rows];
      add(v.row(r) + kStateSize + 1, -row[r], row + rows + 1, globals);
    }
  }
  if (!factorise_rows(s, rows, inverse)) {
    return false;
  }
  forward(s, inverse, rows, v, kStateSize + 1 + globals);

  out.h.setZero();
  out.b.setZero();
  out.border.setZero(kStateSize, globals);
  out.corner = in.corner + clique.own.corner;
  out.corner_b = in.corner_b + clique.own.corner_b;
  for (int r = 0; r < rows; ++r) {
    const double* const row = v.row(r);
    for (int i = 0; i < kStateSize; ++i) {
      add(out.h.data() + i * kStateSize, row[i], row, kStateSize);
    }
    add(out.b.data(), -row[kStateSize], row, kStateSize);
    for (int g = 0; g < globals; ++g) {
      const double by_global = row[kStateSize + 1 + g];
      add(out.border.data() + g * kStateSize, by_global, row, kStateSize);
      out.corner_b[g] -= by_global * row[kStateSize];
      for (int other = 0; other < globals; ++other) {
        out.corner(other, g) += by_global * row[kStateSize + 1 + other];
      }
    }
  }
  for (int i = 0; i < kStateSize; ++i) {
    const double* const row = z.row(i) + rows;
    for (int g = 0; g < globals; ++g) {
      out.corner_b[g] -= row[1 + g] * row[0];
      for (int other = 0; other < globals; ++other) {
        out.corner(other, g) -= row[1 + g] * row[1 + other];
      }
    }
  }
  return true;
}

}  // namespace

void Message::set_zero(int globals) {
  h.setZero();
  b.setZero();
  border.setZero(kStateSize, globals);
  corner.setZero(globals, globals);
  corner_b.setZero(globals);
}

void Clique::set_zero(int number_of_globals) {
  own.set_zero(number_of_globals);
  rows = 0;
  link_h.setZero();
  cross.setZero();
  link_border.setZero(kStateSize, number_of_globals);
  link_b.setZero();
}

void add_row(Clique& clique, const double* from, const double* to, const CornerVector& globals,
             double residual) {
  const bool link = to != nullptr;
  Block& h = link ? clique.link_h : clique.own.h;
  StateVector& b = link ? clique.link_b : clique.own.b;
  Border& border = link ? clique.link_border : clique.own.border;
  for (int i = 0; i < kStateSize; ++i) {
    if (from[i] != 0) {
      add(h.data() + i * kStateSize, from[i], from, kStateSize);
      b[i] -= from[i] * residual;
      if (link) {
        add(clique.cross.data() + i * kStateSize, from[i], to, kStateSize);
      }
    }
  }
  for (Eigen::Index g = 0; g < globals.size(); ++g) {
    if (globals[g] != 0) {
      add(border.data() + g * kStateSize, globals[g], from, kStateSize);
      if (!link) {
        clique.own.corner.col(g) += globals[g] * globals;
        clique.own.corner_b[g] -= globals[g] * residual;
      }
    }
  }
  if (link) {
    std::copy_n(from, kStateSize, clique.from.data() + clique.rows * kStateSize);
    std::copy_n(to, kStateSize, clique.to.data() + clique.rows * kStateSize);
    std::copy_n(globals.data(), globals.size(), clique.globals.data() + clique.rows * kGlobalSize);
    clique.residual[clique.rows] = residual;
    ++clique.rows;
  }
}

bool eliminate(const Clique& clique, const Message& in, const Damping& damping,
               Eliminated& eliminated, Message& out) {
  Unlinked m = unlinked(clique, in, damping);
  eliminated.y = m.b + clique.link_b;
  eliminated.border = m.border + clique.link_border;
  if (!factorise_state(m.h + clique.link_h, eliminated)) {
    return false;
  }
  eliminated.cross = clique.cross;
  forward(rows_of(eliminated.root), eliminated.inverse_diagonal.data(), kStateSize,
          rows_of(eliminated.cross), kStateSize);
  return pass_on(clique, in, m, out);
}

bool eliminate_last(const Clique& clique, const Message& in, const Damping& damping,
                    Eliminated& eliminated, Message& out) {
  const Unlinked m = unlinked(clique, in, damping);
  eliminated.y = m.b;
  eliminated.border = m.border;
  if (!factorise_state(m.h, eliminated)) {
    return false;
  }
  out.corner = in.corner + clique.own.corner;
  out.corner_b = in.corner_b + clique.own.corner_b;
  out.corner.noalias() -= eliminated.border.transpose().lazyProduct(eliminated.border);
  out.corner_b.noalias() -= eliminated.border.transpose().lazyProduct(eliminated.y);
  return true;
}

StateVector substitute(const Eliminated& eliminated, const StateVector* next,
                       const CornerVector& globals) {
  StateVector x = eliminated.y;
  if (next != nullptr) {
    x.noalias() -= eliminated.cross.lazyProduct(*next);
  }
  if (globals.size() > 0) {
    x.noalias() -= eliminated.border.lazyProduct(globals);
  }
  for (int i = kStateSize - 1; i >= 0; --i) {
    const double* const row = eliminated.root.data() + i * kStateSize;
    double rest = x[i];
    for (int j = i + 1; j < kStateSize; ++j) {
      rest -= row[j] * x[j];
    }
    x[i] = rest * eliminated.inverse_diagonal[i];
  }
  return x;
}

bool factorise(Corner& corner) {
  for (Eigen::Index k = 0; k < corner.rows(); ++k) {
    const double before = corner(k, k);
    double pivot = before;
    for (Eigen::Index j = 0; j < k; ++j) {
      pivot -= corner(k, j) * corner(k, j);
    }
    if (!(pivot > kLeastPivot * before) || !std::isfinite(pivot)) {
      return false;
    }
    corner(k, k) = std::sqrt(pivot);
    for (Eigen::Index i = k + 1; i < corner.rows(); ++i) {
      double rest = corner(i, k);
      for (Eigen::Index j = 0; j < k; ++j) {
        rest -= corner(i, j) * corner(k, j);
      }
      corner(i, k) = rest / corner(k, k);
      corner(k, i) = 0;
    }
  }
  return true;
}

}  // namespace pipescout::estimation
