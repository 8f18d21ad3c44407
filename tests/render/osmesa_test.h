#pragma once

#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "render/gl_context.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// Tests that draw, each suite in an OSMesa context of its own.
class OsMesaTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto context = HeadlessContext::create(Headless::kOsMesa);
    ASSERT_TRUE(context) << context.error().text();
    context_ = std::move(*context);
    auto gl = load_gl(context_->get_function());
    ASSERT_TRUE(gl) << gl.error().text();
    gl_ = std::move(*gl);
  }
  static void TearDownTestSuite() { context_.reset(); }

  static inline std::unique_ptr<HeadlessContext> context_;
  static inline GlFunctions gl_;
};

}  // namespace tintree::render
