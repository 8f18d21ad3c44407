#include "tests/bench/scene/error_ladder.h"

#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

namespace tintree::bench {
namespace {

double total(const GroundBlocks& blocks) {
  return std::accumulate(blocks.triangles.begin(), blocks.triangles.end(), 0.0);
}

}  // namespace

void ErrorLadder::add(double error_m, GroundBlocks blocks) { rungs_.insert_or_assign(error_m, std::move(blocks)); }

double ErrorLadder::triangles(std::size_t block, double error_m) const {
  const auto above = rungs_.lower_bound(error_m);
  if (above == rungs_.begin()) return ground().triangles[block];
  if (above == rungs_.end()) return beyond(block, error_m);
  const auto below = std::prev(above);
  const double fine = below->second.triangles[block];
  const double coarse = above->second.triangles[block];
  const double t = std::log(error_m / below->first) / std::log(above->first / below->first);
  if (fine <= 0 || coarse <= 0) return fine + t * (coarse - fine);
  return fine * std::pow(coarse / fine, t);
}

double ErrorLadder::beyond(std::size_t block, double error_m) const {
  const auto last = std::prev(rungs_.end());
  const double here = last->second.triangles[block];
  if (last == rungs_.begin()) return here;
  const auto before = std::prev(last);
  const double slope = std::log(total(last->second) / total(before->second)) / std::log(last->first / before->first);
  return here * std::pow(error_m / last->first, slope);
}

}  // namespace tintree::bench
