// SPDX-License-Identifier: Apache-2.0
// OpenGL ES 3.0, as WebGL2 has it, with the names of OpenGL 4.3 that it lacks. These belong to the compute
// entry, which its contexts do not have, so that none of them is reached.
#pragma once

#include <GLES3/gl3.h>

#include <cstddef>
#include <cstdint>

inline constexpr GLenum GL_COMPUTE_SHADER = 0x91B9;
inline constexpr GLenum GL_SHADER_STORAGE_BUFFER = 0x90D2;
inline constexpr GLenum GL_SHADER_STORAGE_BUFFER_BINDING = 0x90D3;
inline constexpr GLenum GL_SHADER_STORAGE_BUFFER_START = 0x90D4;
inline constexpr GLenum GL_SHADER_STORAGE_BUFFER_SIZE = 0x90D5;
inline constexpr GLenum GL_MAX_SHADER_STORAGE_BLOCK_SIZE = 0x90DE;
inline constexpr GLbitfield GL_BUFFER_UPDATE_BARRIER_BIT = 0x00000200;
inline constexpr GLbitfield GL_SHADER_STORAGE_BARRIER_BIT = 0x00002000;

// What glGetError() of WebGL answers once its context is lost.
inline constexpr GLenum GL_CONTEXT_LOST = 0x9242;

inline void glDispatchCompute(GLuint /*x*/, GLuint /*y*/, GLuint /*z*/) {}
inline void glMemoryBarrier(GLbitfield /*barriers*/) {}
inline void glGetBufferSubData(GLenum /*target*/, GLintptr /*offset*/, GLsizeiptr /*size*/, void* /*out*/) {}
