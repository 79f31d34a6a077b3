// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "pipescout/estimation/state.hpp"

/// Normal equations H d = b of a chain of states with a border of global states, eliminated state
/// by state. Blocks are stored by rows, so that the inner loops run over 15 neighbours in memory.
/// Nothing here allocates.
namespace pipescout::estimation {

using Block = Eigen::Matrix<double, kStateSize, kStateSize, Eigen::RowMajor>;
/// 15 x number of global states that are estimated, at most all.
using Border =
    Eigen::Matrix<double, kStateSize, Eigen::Dynamic, Eigen::ColMajor, kStateSize, kGlobalSize>;
using Corner = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kGlobalSize,
                             kGlobalSize>;
using CornerVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kGlobalSize, 1>;

/// Information about one state and the globals.
struct Message {
  Block h;        // state
  Border border;  // state by globals
  Corner corner;  // globals
  StateVector b;
  CornerVector corner_b;

  void set_zero(int globals);
};

/// The factors of one state, of its link to the next, and of the globals. Those of the state alone
/// are summed up; the rows that link it are kept: `from` d + `to` d_next + `globals` d_globals +
/// `residual`, each of covariance 1.
struct Clique {
  static constexpr int kMaxRows = 33;
  Message own;
  int rows = 0;
  Eigen::Matrix<double, kMaxRows, kStateSize, Eigen::RowMajor> from;
  Eigen::Matrix<double, kMaxRows, kStateSize, Eigen::RowMajor> to;
  Eigen::Matrix<double, kMaxRows, kGlobalSize, Eigen::RowMajor> globals;  // the first so many
  Eigen::Matrix<double, kMaxRows, 1> residual;
  // Sums over the rows, as far as they concern the state.
  Block link_h;
  Block cross;
  Border link_border;
  StateVector link_b;

  void set_zero(int globals);
};

/// What is left of a state's equations: U d = y - cross d_next - border d_globals, with U^T U its
/// information.
struct Eliminated {
  Block root;  // U in the upper triangle, nothing of use below it
  StateVector inverse_diagonal;
  Block cross;
  Border border;
  StateVector y;
};

/// How the equations are damped: damping times their diagonal pulls a state to `centre`.
struct Damping {
  double factor = 0;
  StateVector centre = StateVector::Zero();
};

/// Eliminates a state that has a next one; there must be a row for each direction of that. False
/// when the information is not positive definite to rounding; the outputs are not to be used then.
///
/// Links may be a billion times surer than what is known of the states themselves, so that the
/// difference by which a Schur complement is defined would be rounding. With M the information
/// without the link and F_i, F_j its rows it is F_j^T (1 + F_i M^-1 F_i^T)^-1 F_j, which has none.
[[nodiscard]] bool eliminate(const Clique& clique, const Message& in, const Damping& damping,
                             Eliminated& eliminated, Message& out);

/// Eliminates the newest state, which has none; of `out` the globals' part alone is set.
[[nodiscard]] bool eliminate_last(const Clique& clique, const Message& in, const Damping& damping,
                                  Eliminated& eliminated, Message& out);

/// The state itself, given the next one and the globals. `next` is null for the newest state.
[[nodiscard]] StateVector substitute(const Eliminated& eliminated, const StateVector* next,
                                     const CornerVector& globals);

/// Cholesky factor of the globals' own information, lower triangular, in place. False as above.
[[nodiscard]] bool factorise(Corner& corner);

/// U^-T x in place, for the columns of x.
template <class Columns>
void solve_root(const Eliminated& eliminated, Columns& x) {
  for (int i = 0; i < kStateSize; ++i) {
    x.row(i) *= eliminated.inverse_diagonal[i];
    for (int j = i + 1; j < kStateSize; ++j) {
      x.row(j) -= eliminated.root(i, j) * x.row(i);
    }
  }
}

/// Adds one row of a factor, residual + from d + to d_next + globals d_globals. `to` may be null:
/// no link. Zeros are skipped. Not checked: no more than Clique::kMaxRows links.
void add_row(Clique& clique, const double* from, const double* to, const CornerVector& globals,
             double residual);

}  // namespace pipescout::estimation
