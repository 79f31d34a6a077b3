// SPDX-License-Identifier: Apache-2.0
#include "chain_elimination.hpp"

#include <cmath>

namespace pipescout::estimation {
namespace {

/// Pivots below this part of their diagonal are rounding.
constexpr double kLeastPivot = 1e-13;

/// to -= factor * from, 15 numbers each.
inline void subtract(double* to, double factor, const double* from) {
  for (int i = 0; i < kStateSize; ++i) {
    to[i] -= factor * from[i];
  }
}

/// The Cholesky factor of `a`, of which the lower triangle is read, into `eliminated`.
bool factorise_state(const Block& a, Eliminated& eliminated) {
  // Right-looking, over the upper triangle by rows: the transposed factor.
  Block upper = a.transpose();
  for (int k = 0; k < kStateSize; ++k) {
    const double pivot = upper(k, k);
    if (!(pivot > kLeastPivot * a(k, k)) || !std::isfinite(pivot)) {
      return false;
    }
    const double scale = 1 / std::sqrt(pivot);
    eliminated.inverse_diagonal[k] = scale;
    double* row = upper.data() + k * kStateSize;
    for (int j = 0; j < kStateSize; ++j) {
      row[j] *= scale;
    }
    for (int i = k + 1; i < kStateSize; ++i) {
      subtract(upper.data() + i * kStateSize, row[i], row);
    }
  }
  eliminated.root = upper.transpose();
  return true;
}

bool eliminate_state(const Clique& clique, const Message& in, const Damping& damping,
                     Eliminated& eliminated) {
  Block a = clique.own.h + in.h;
  eliminated.y = clique.own.b + in.b;
  if (damping.factor > 0) {
    const StateVector added = damping.factor * a.diagonal();
    a.diagonal() += added;
    eliminated.y += added.cwiseProduct(damping.centre);
  }
  if (!factorise_state(a, eliminated)) {
    return false;
  }
  solve_root(eliminated, eliminated.y);
  eliminated.border = clique.own.border + in.border;
  solve_root(eliminated, eliminated.border);
  return true;
}

void pass_on_corner(const Clique& clique, const Message& in, const Eliminated& eliminated,
                    Message& out) {
  out.corner = in.corner + clique.own.corner;
  out.corner_b = in.corner_b + clique.own.corner_b;
  if (out.corner_b.size() > 0) {
    out.corner.noalias() -= eliminated.border.transpose().lazyProduct(eliminated.border);
    out.corner_b.noalias() -= eliminated.border.transpose().lazyProduct(eliminated.y);
  }
}

}  // namespace

void Message::set_zero(int globals) {
  h.setZero();
  b.setZero();
  border.setZero(kStateSize, globals);
  corner.setZero(globals, globals);
  corner_b.setZero(globals);
}

void Clique::set_zero(int globals) {
  own.set_zero(globals);
  cross.setZero();
  next.setZero();
  next_border.setZero(kStateSize, globals);
  next_b.setZero();
}

bool eliminate(const Clique& clique, const Message& in, const Damping& damping,
               Eliminated& eliminated, Message& out) {
  if (!eliminate_state(clique, in, damping, eliminated)) {
    return false;
  }
  eliminated.cross = clique.cross;
  out.h = clique.next;
  out.b = clique.next_b;
  out.border = clique.next_border;
  double* cross = eliminated.cross.data();
  for (int i = 0; i < kStateSize; ++i) {
    double* row = cross + i * kStateSize;
    for (int j = 0; j < kStateSize; ++j) {
      row[j] *= eliminated.inverse_diagonal[i];
    }
    for (int j = i + 1; j < kStateSize; ++j) {
      subtract(cross + j * kStateSize, eliminated.root(j, i), row);
    }
    for (int j = 0; j < kStateSize; ++j) {
      subtract(out.h.data() + j * kStateSize, row[j], row);
    }
    subtract(out.b.data(), eliminated.y[i], row);
  }
  if (out.corner_b.size() > 0 || clique.own.corner_b.size() > 0) {
    out.border.noalias() -= eliminated.cross.transpose().lazyProduct(eliminated.border);
  }
  pass_on_corner(clique, in, eliminated, out);
  return true;
}

bool eliminate_last(const Clique& clique, const Message& in, const Damping& damping,
                    Eliminated& eliminated, Message& out) {
  if (!eliminate_state(clique, in, damping, eliminated)) {
    return false;
  }
  pass_on_corner(clique, in, eliminated, out);
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
    x[i] *= eliminated.inverse_diagonal[i];
    const double* row = eliminated.root.data() + i * kStateSize;
    for (int j = 0; j < i; ++j) {
      x[j] -= x[i] * row[j];
    }
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

void add_row(Clique& clique, const double* from, const double* to, const CornerVector& globals,
             double residual) {
  for (int i = 0; i < kStateSize; ++i) {
    if (from[i] != 0) {
      subtract(clique.own.h.data() + i * kStateSize, -from[i], from);
      clique.own.b[i] -= from[i] * residual;
      if (to != nullptr) {
        subtract(clique.cross.data() + i * kStateSize, -from[i], to);
      }
    }
    if (to != nullptr && to[i] != 0) {
      subtract(clique.next.data() + i * kStateSize, -to[i], to);
      clique.next_b[i] -= to[i] * residual;
    }
  }
  for (Eigen::Index g = 0; g < globals.size(); ++g) {
    if (globals[g] != 0) {
      subtract(clique.own.border.data() + g * kStateSize, -globals[g], from);
      if (to != nullptr) {
        subtract(clique.next_border.data() + g * kStateSize, -globals[g], to);
      }
      clique.own.corner.col(g) += globals[g] * globals;
      clique.own.corner_b[g] -= globals[g] * residual;
    }
  }
}

}  // namespace pipescout::estimation
