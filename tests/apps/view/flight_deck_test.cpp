#include "apps/view/flight_deck.h"

#include <gtest/gtest.h>

namespace tintree::view {
namespace {

render::Camera at(double x) {
  render::Camera c;
  c.eye = {x, 0, 100};
  c.target = {x, 1000, 0};
  return c;
}

TEST(FlightDeck, PlaysWhatItRecorded) {
  FlightDeck deck(std::nullopt);
  EXPECT_FALSE(deck.play(0));
  deck.begin_recording(at(0), 10);
  for (double now = 10; now < 12; now += 0.05) deck.note(at(100 * (now - 10)), now);
  const auto flight = deck.end_recording(at(200), 12);
  ASSERT_TRUE(flight) << flight.error().text();
  EXPECT_FALSE(deck.recording());
  EXPECT_NEAR(flight->end_s() - flight->begin_s(), 2, 1e-9);
  EXPECT_LT(flight->keyframes().size(), 11U);
  // Even motion comes back evenly, from the moment it is played.
  ASSERT_TRUE(deck.play(100));
  EXPECT_NEAR(deck.view(100.8, 640, 480)->eye.x, 80, 1);
  EXPECT_EQ(deck.view(100.8, 640, 480)->width_px, 640);
  EXPECT_NEAR(deck.view(105, 640, 480)->eye.x, 200, 1e-9);
  EXPECT_FALSE(deck.playing());
  EXPECT_FALSE(deck.view(106, 640, 480));
}

TEST(FlightDeck, RefusesARecordingOfNoTime) {
  FlightDeck deck(std::nullopt);
  deck.begin_recording(at(0), 10);
  EXPECT_FALSE(deck.end_recording(at(0), 10));
  EXPECT_FALSE(deck.recording());
}

}  // namespace
}  // namespace tintree::view
