#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "codec/quick_bit_model.h"
#include "codec/range_coder.h"
#include "codec/tin_front.h"

namespace tintree::codec {

/// What a TinWalk knows of bits and numbers. A tile is too short to learn it all: the models begin as if numbers and
/// bits as they are on average in other tiles had been coded before (docs/format.md has the lists).
struct TinModels {
  using Number = NumberModelOf<QuickBitModel>;
  using ByTurns = std::array<std::array<QuickBitModel, 3>, TinFront::kTurns>;

  QuickBitModel more;                                  ///< Another piece of the mesh.
  QuickBitModel last;                                  ///< A loop of three is one triangle.
  std::array<QuickBitModel, 2> fresh;                  ///< The vertex is new, by whether the gate's angle is wide.
  std::array<std::array<QuickBitModel, 3>, 4> border;  ///< By which neighbouring edges are closed, and the angle.
  ByTurns back;                                        ///< The vertex is that before the gate, by the gate's angles.
  ByTurns ahead;                                       ///< The vertex is that after the gate.
  Number first_height;
  Number height;
  Number gap;  ///< Between vertices along the rectangle.
  std::array<Number, 2> start;
  Number across;
  Number along;
  Number split;

  /// As every mesh begins.
  static const TinModels& begun() {
    static const TinModels models;
    return models;
  }

 private:
  TinModels() {
    repeat(last, 8, 8);
    for (QuickBitModel& model : fresh) repeat(model, 8, 8);
    constexpr std::array kBack{7, 5, 4, 2, 1, 0};
    constexpr std::array kAhead{7, 6, 5, 3, 2, 0};
    for (std::size_t turn = 0; turn < kBack.size(); ++turn) {
      for (QuickBitModel& model : back[turn]) repeat(model, kBack[turn], 8);
      for (QuickBitModel& model : ahead[turn]) repeat(model, kAhead[turn], 8);
    }
    learn(height, {-17, -10, -7, -4, -3, -1, -1, 0, 0, 0, 1, 3, 5, 7, 11, 19});
    learn(gap, {1, 1, 2, 3, 3, 3, 5, 5, 7, 7, 9, 11, 15, 23, 35, 63});
    learn(across, {-7, -5, -4, -3, -3, -2, -2, -1, -1, -1, 0, 0, 1, 2, 4, 8});
    learn(along, {-6, -4, -2, -2, -1, 0, 0, 0, 1, 1, 2, 3, 3, 5, 6, 9});
    learn(split, {-6, -3, -2, -1, -1, -1, -1, 0, 1, 5});
  }

  /// A coder without bytes.
  struct Learner {
    bool bit(QuickBitModel& model, bool value) {
      model.learn(value);
      return value;
    }
    bool bit(bool value) { return value; }
  };

  static void repeat(QuickBitModel& model, int ones, int all) {
    for (int i = 0; i < all; ++i) model.learn(i < ones);
  }
  template <std::size_t N>
  static void learn(Number& model, const std::int64_t (&numbers)[N]) {
    Learner learner;
    for (const std::int64_t number : numbers) model.code(learner, number);
  }
};

}  // namespace tintree::codec
