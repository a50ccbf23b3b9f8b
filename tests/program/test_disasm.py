"""Disassembly of small kernels, as golden text."""

from __future__ import annotations

from tests.program.hand_kernels import dot, fabric, find
from vividc.program import disassemble

DOT = """\
program dot on hand
launch: PE 0 c0 = n
launch: PE 0 c1 = &x
launch: PE 3 c0 = &y
image: PE 1 c0 = 0x00000000
return: PE 1 c2

region 0 start: straight, length 2, then region 1
    0: PE  0  mov c0 !trip @s0  ; kernels/hand.py:1
    0: PE  1  mov c0 @s0  ; kernels/hand.py:3
    1: PE  1  c1=out @s0  ; kernels/hand.py:5

region 1 loop: loop counted, II 4, span 6, 2 stages, then region 2
    0: PE  0  load [c1 + (iv << 2) +0] @s0  ->1=res  ; kernels/hand.py:2
    0: PE  3  load [c0 + (iv << 2) +0] @s0  ->1=res  ; kernels/hand.py:4
    1: PE  1  fma link<-0, link<-3, c0|out @s0  c1=out @s1  ; kernels/hand.py:6, kernels/hand.py:8
    2: idle
    3: idle

region 2 end: straight, length 2, then end
    0: PE  1  mov c1 @s0  ; kernels/hand.py:1
    1: PE  1  c2=out @s0  ; kernels/hand.py:3
"""


def test_dot() -> None:
    assert disassemble(dot(fabric(latencies="{fma: 4}"))) == DOT


def test_exit_loop_shows_its_marks() -> None:
    text = disassemble(find(fabric()))
    assert "region 0 search: loop exit, II 1, span 4, 4 stages, then end" in text
    assert "!exit @s1" in text
    assert "!unless_exit @s3" in text
