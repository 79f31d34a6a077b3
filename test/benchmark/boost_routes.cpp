// SPDX-License-Identifier: Apache-2.0
#include "boost_routes.hpp"

#include <algorithm>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/dijkstra_shortest_paths.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace pipescout::benchmarks {
namespace {

struct Weight {
  double weight = 0;
};
using CsrGraph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, Weight>;

struct Reached {};

class StopAtGoal : public boost::default_dijkstra_visitor {
 public:
  explicit StopAtGoal(std::size_t goal) : goal_(goal) {}
  void examine_vertex(std::size_t vertex, const CsrGraph& /*graph*/) const {
    if (vertex == goal_) {
      throw Reached{};  // the library's own way to end early
    }
  }

 private:
  std::size_t goal_;
};

}  // namespace

class BoostRoutes::Graph {
 public:
  explicit Graph(const navigation::RouteGraph& graph) : distances_(graph.nodes().size()) {
    std::vector<std::pair<std::size_t, std::size_t>> ends;
    std::vector<Weight> weights;
    for (std::uint32_t i = 0; i < graph.edges().size(); ++i) {
      ends.emplace_back(graph.edges()[i].from, graph.edges()[i].to);
      weights.push_back({graph.edges()[i].cost.value_or(graph.length(i))});
    }
    graph_ = CsrGraph(boost::edges_are_unsorted_multi_pass, ends.begin(), ends.end(),
                      weights.begin(), graph.nodes().size());
  }

  double cost(std::uint32_t from, std::uint32_t to) {
    std::fill(distances_.begin(), distances_.end(), std::numeric_limits<double>::infinity());
    try {
      boost::dijkstra_shortest_paths(
          graph_, from,
          boost::weight_map(boost::get(&Weight::weight, graph_))
              .distance_map(boost::make_iterator_property_map(
                  distances_.begin(), boost::get(boost::vertex_index, graph_)))
              .visitor(StopAtGoal(to)));
    } catch (const Reached&) {
      return distances_[to];
    }
    return std::numeric_limits<double>::infinity();
  }

 private:
  CsrGraph graph_;
  std::vector<double> distances_;
};

BoostRoutes::BoostRoutes(const navigation::RouteGraph& graph)
    : graph_(std::make_unique<Graph>(graph)) {}
BoostRoutes::~BoostRoutes() = default;

double BoostRoutes::cost(std::uint32_t from, std::uint32_t to) {
  return graph_->cost(from, to);
}

}  // namespace pipescout::benchmarks
