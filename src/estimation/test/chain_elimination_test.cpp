// SPDX-License-Identifier: Apache-2.0
// Elimination along the chain against the dense equations.
#include "chain_elimination.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace pipescout::estimation {
namespace {

using Dense = Eigen::MatrixXd;
using DenseVector = Eigen::VectorXd;

/// Random factors over a chain of states and globals, as cliques and as dense equations.
struct RandomChain {
  RandomChain(std::uint64_t seed, int states, int number_of_globals)
      : cliques(static_cast<std::size_t>(states)),
        globals(number_of_globals),
        h(Dense::Zero(states * kStateSize + globals, states * kStateSize + globals)),
        b(DenseVector::Zero(h.rows())) {
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(engine); };
    for (int k = 0; k < states; ++k) {
      Clique& clique = cliques[static_cast<std::size_t>(k)];
      clique.set_zero(globals);
      const bool last = k + 1 == states;
      for (int row = 0; row < 60; ++row) {
        StateVector from = StateVector::NullaryExpr(draw);
        from[row % kStateSize] = 0;
        const bool link = !last && row % 2 != 0;
        const StateVector to =
            !link ? StateVector::Zero() : StateVector(StateVector::NullaryExpr(draw));
        CornerVector by_globals(globals);
        for (int g = 0; g < globals; ++g) {
          by_globals[g] = g == row % 3 ? 0 : draw();
        }
        const double residual = draw();
        add_row(clique, from.data(), link ? to.data() : nullptr, by_globals, residual);
        DenseVector whole = DenseVector::Zero(h.rows());
        whole.segment<kStateSize>(k * kStateSize) = from;
        if (!last) {
          whole.segment<kStateSize>((k + 1) * kStateSize) = to;
        }
        whole.tail(globals) = by_globals;
        h += whole * whole.transpose();
        b -= residual * whole;
      }
    }
  }

  std::vector<Clique> cliques;
  int globals;
  Dense h;
  DenseVector b;
};

class ChainEliminationTest : public testing::TestWithParam<int> {};

TEST_P(ChainEliminationTest, SolvesTheDenseEquations) {
  constexpr int kStates = 5;
  for (const int globals : {0, 1, 7, 13}) {
    for (const double damping : {0.0, 0.3}) {
      const RandomChain chain(static_cast<std::uint64_t>(GetParam()), kStates, globals);
      Damping towards{.factor = damping, .centre = StateVector::Constant(0.5)};
      std::vector<Message> in(kStates + 1);
      in[0].set_zero(globals);
      std::vector<Eliminated> eliminated(kStates);
      for (std::size_t k = 0; k + 1 < kStates; ++k) {
        ASSERT_TRUE(eliminate(chain.cliques[k], in[k], towards, eliminated[k], in[k + 1]));
      }
      ASSERT_TRUE(eliminate_last(chain.cliques[4], in[4], towards, eliminated[4], in[kStates]));
      Corner root = in[kStates].corner;
      ASSERT_TRUE(factorise(root));
      CornerVector d_globals = in[kStates].corner_b;
      root.triangularView<Eigen::Lower>().solveInPlace(d_globals);
      root.transpose().triangularView<Eigen::Upper>().solveInPlace(d_globals);
      DenseVector solution(chain.h.rows());
      solution.tail(globals) = d_globals;
      StateVector next;
      for (int k = kStates - 1; k >= 0; --k) {
        const StateVector d = substitute(eliminated[static_cast<std::size_t>(k)],
                                         k + 1 < kStates ? &next : nullptr, d_globals);
        solution.segment<kStateSize>(k * kStateSize) = d;
        next = d;
      }
      if (damping == 0) {
        const DenseVector dense = chain.h.llt().solve(chain.b);
        EXPECT_LT((solution - dense).norm(), 1e-8 * dense.norm());
        // What the first two states leave is the Schur complement.
        const Dense rest = chain.h.bottomRightCorner(chain.h.rows() - 30, chain.h.rows() - 30);
        const Dense left = chain.h.bottomLeftCorner(rest.rows(), 30);
        const Dense schur =
            rest - left * chain.h.topLeftCorner(30, 30).llt().solve(Dense(left.transpose()));
        const Dense with_clique = in[2].h + chain.cliques[2].own.h + chain.cliques[2].link_h;
        EXPECT_LT((schur.topLeftCorner(15, 15) - with_clique).norm(), 1e-8 * schur.norm());
      } else {
        // Damping is that of the diagonal at the elimination of each state: it shortens the step.
        const DenseVector dense = chain.h.llt().solve(chain.b);
        EXPECT_GT((solution - dense).norm(), 1e-3 * dense.norm());
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ChainEliminationTest, testing::Range(1, 6));

TEST(StiffChainTest, ALinkMuchSurerThanTheStatesKeepsWhatIsKnownOfThem) {
  // Deviation 1 km of the first state, 1e-6 m of the link: the second's is that of the first.
  Clique clique;
  clique.set_zero(0);
  Message in;
  in.set_zero(0);
  in.h.diagonal().setConstant(1e-6);
  for (int i = 0; i < kStateSize; ++i) {
    const StateVector from = -1e6 * StateVector::Unit(i);
    const StateVector to = 1e6 * StateVector::Unit(i);
    add_row(clique, from.data(), to.data(), CornerVector(0), 0);
  }
  Eliminated eliminated;
  Message out;
  ASSERT_TRUE(eliminate(clique, in, {}, eliminated, out));
  EXPECT_LT((1e6 * out.h - StateMatrix::Identity()).norm(), 1e-9);
}

TEST(SingularChainTest, WhatIsSingularIsSaid) {
  Clique clique;
  clique.set_zero(0);
  Message in;
  in.set_zero(0);
  Eliminated eliminated;
  Message out;
  EXPECT_FALSE(eliminate_last(clique, in, {}, eliminated, out));
  clique.own.h.setIdentity();
  EXPECT_TRUE(eliminate_last(clique, in, {}, eliminated, out));
  clique.own.h(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(eliminate(clique, in, {}, eliminated, out));
  // Two directions that are one to rounding.
  clique.own.h.setIdentity();
  clique.own.h(4, 5) = clique.own.h(5, 4) = 1;
  EXPECT_FALSE(eliminate_last(clique, in, {}, eliminated, out));
  Corner corner = -Corner::Identity(2, 2);
  EXPECT_FALSE(factorise(corner));
}

}  // namespace
}  // namespace pipescout::estimation
