// The types of shape.idl and final_shape.idl. Both are named "ShapeType" on the wire.
#pragma once

#include <final_shape.hpp>
#include <shape.hpp>

namespace ddssec::shapes {

using FinalShapeType = finals::ShapeType;

}  // namespace ddssec::shapes
