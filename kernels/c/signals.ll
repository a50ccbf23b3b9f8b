; ModuleID = 'signals.c'
source_filename = "signals.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

%struct.biquad = type { float, float, float, float, float, float, float }

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @fir(ptr nocapture noundef readonly %0, ptr nocapture noundef readonly %1, ptr nocapture noundef writeonly %2, i32 noundef %3) local_unnamed_addr #0 !dbg !9 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !17, metadata !DIExpression()), !dbg !28
  call void @llvm.dbg.value(metadata ptr %1, metadata !18, metadata !DIExpression()), !dbg !28
  call void @llvm.dbg.value(metadata ptr %2, metadata !19, metadata !DIExpression()), !dbg !28
  call void @llvm.dbg.value(metadata i32 %3, metadata !20, metadata !DIExpression()), !dbg !28
  call void @llvm.dbg.value(metadata i32 0, metadata !21, metadata !DIExpression()), !dbg !29
  %5 = icmp slt i32 %3, 8, !dbg !30
  br i1 %5, label %11, label %6, !dbg !31

6:                                                ; preds = %4
  %7 = add nsw i32 %3, -7, !dbg !31
  %8 = zext i32 %7 to i64, !dbg !30
  br label %9, !dbg !31

9:                                                ; preds = %6, %12
  %10 = phi i64 [ 0, %6 ], [ %14, %12 ]
  call void @llvm.dbg.value(metadata i64 %10, metadata !21, metadata !DIExpression()), !dbg !29
  call void @llvm.dbg.value(metadata i32 0, metadata !26, metadata !DIExpression()), !dbg !32
  call void @llvm.dbg.value(metadata i32 0, metadata !23, metadata !DIExpression()), !dbg !33
  br label %16, !dbg !34

11:                                               ; preds = %12, %4
  ret void, !dbg !35

12:                                               ; preds = %16
  %13 = getelementptr inbounds i32, ptr %2, i64 %10, !dbg !36
  store i32 %25, ptr %13, align 4, !dbg !37, !tbaa !38
  %14 = add nuw nsw i64 %10, 1, !dbg !42
  call void @llvm.dbg.value(metadata i64 %14, metadata !21, metadata !DIExpression()), !dbg !29
  %15 = icmp eq i64 %14, %8, !dbg !30
  br i1 %15, label %11, label %9, !dbg !31, !llvm.loop !43

16:                                               ; preds = %9, %16
  %17 = phi i64 [ 0, %9 ], [ %26, %16 ]
  %18 = phi i32 [ 0, %9 ], [ %25, %16 ]
  call void @llvm.dbg.value(metadata i64 %17, metadata !26, metadata !DIExpression()), !dbg !32
  call void @llvm.dbg.value(metadata i32 %18, metadata !23, metadata !DIExpression()), !dbg !33
  %19 = add nuw nsw i64 %17, %10, !dbg !47
  %20 = getelementptr inbounds i32, ptr %0, i64 %19, !dbg !49
  %21 = load i32, ptr %20, align 4, !dbg !49, !tbaa !38
  %22 = getelementptr inbounds i32, ptr %1, i64 %17, !dbg !50
  %23 = load i32, ptr %22, align 4, !dbg !50, !tbaa !38
  %24 = mul nsw i32 %23, %21, !dbg !51
  %25 = add nsw i32 %24, %18, !dbg !52
  call void @llvm.dbg.value(metadata i32 %25, metadata !23, metadata !DIExpression()), !dbg !33
  %26 = add nuw nsw i64 %17, 1, !dbg !53
  call void @llvm.dbg.value(metadata i64 %26, metadata !26, metadata !DIExpression()), !dbg !32
  %27 = icmp eq i64 %26, 8, !dbg !54
  br i1 %27, label %12, label %16, !dbg !34, !llvm.loop !55
}

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @biquad(ptr nocapture noundef %0, ptr nocapture noundef readonly %1, ptr nocapture noundef writeonly %2, i32 noundef %3) local_unnamed_addr #1 !dbg !57 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !75, metadata !DIExpression()), !dbg !85
  call void @llvm.dbg.value(metadata ptr %1, metadata !76, metadata !DIExpression()), !dbg !85
  call void @llvm.dbg.value(metadata ptr %2, metadata !77, metadata !DIExpression()), !dbg !85
  call void @llvm.dbg.value(metadata i32 %3, metadata !78, metadata !DIExpression()), !dbg !85
  call void @llvm.dbg.value(metadata i32 0, metadata !79, metadata !DIExpression()), !dbg !86
  %5 = icmp sgt i32 %3, 0, !dbg !87
  br i1 %5, label %6, label %14, !dbg !88

6:                                                ; preds = %4
  %7 = getelementptr inbounds %struct.biquad, ptr %0, i64 0, i32 5
  %8 = getelementptr inbounds %struct.biquad, ptr %0, i64 0, i32 1
  %9 = getelementptr inbounds %struct.biquad, ptr %0, i64 0, i32 3
  %10 = getelementptr inbounds %struct.biquad, ptr %0, i64 0, i32 6
  %11 = getelementptr inbounds %struct.biquad, ptr %0, i64 0, i32 2
  %12 = getelementptr inbounds %struct.biquad, ptr %0, i64 0, i32 4
  %13 = zext i32 %3 to i64, !dbg !87
  br label %15, !dbg !88

14:                                               ; preds = %15, %4
  ret void, !dbg !89

15:                                               ; preds = %6, %15
  %16 = phi i64 [ 0, %6 ], [ %35, %15 ]
  call void @llvm.dbg.value(metadata i64 %16, metadata !79, metadata !DIExpression()), !dbg !86
  %17 = getelementptr inbounds float, ptr %1, i64 %16, !dbg !90
  %18 = load float, ptr %17, align 4, !dbg !90, !tbaa !91
  call void @llvm.dbg.value(metadata float %18, metadata !81, metadata !DIExpression()), !dbg !93
  %19 = load float, ptr %0, align 4, !dbg !94, !tbaa !95
  %20 = load float, ptr %7, align 4, !dbg !97, !tbaa !98
  %21 = tail call float @llvm.fmuladd.f32(float %19, float %18, float %20), !dbg !99
  call void @llvm.dbg.value(metadata float %21, metadata !84, metadata !DIExpression()), !dbg !93
  %22 = load float, ptr %8, align 4, !dbg !100, !tbaa !101
  %23 = load float, ptr %9, align 4, !dbg !102, !tbaa !103
  %24 = fneg float %23, !dbg !104
  %25 = fmul float %21, %24, !dbg !104
  %26 = tail call float @llvm.fmuladd.f32(float %22, float %18, float %25), !dbg !104
  %27 = load float, ptr %10, align 4, !dbg !105, !tbaa !106
  %28 = fadd float %27, %26, !dbg !107
  store float %28, ptr %7, align 4, !dbg !108, !tbaa !98
  %29 = load float, ptr %11, align 4, !dbg !109, !tbaa !110
  %30 = load float, ptr %12, align 4, !dbg !111, !tbaa !112
  %31 = fneg float %30, !dbg !113
  %32 = fmul float %21, %31, !dbg !113
  %33 = tail call float @llvm.fmuladd.f32(float %29, float %18, float %32), !dbg !113
  store float %33, ptr %10, align 4, !dbg !114, !tbaa !106
  %34 = getelementptr inbounds float, ptr %2, i64 %16, !dbg !115
  store float %21, ptr %34, align 4, !dbg !116, !tbaa !91
  %35 = add nuw nsw i64 %16, 1, !dbg !117
  call void @llvm.dbg.value(metadata i64 %35, metadata !79, metadata !DIExpression()), !dbg !86
  %36 = icmp eq i64 %35, %13, !dbg !87
  br i1 %36, label %14, label %15, !dbg !88, !llvm.loop !118
}

; Function Attrs: mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare float @llvm.fmuladd.f32(float, float, float) #2

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @jacobi2d(i32 noundef %0, i32 noundef %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef writeonly %3) local_unnamed_addr #0 !dbg !120 {
  call void @llvm.dbg.value(metadata i32 %0, metadata !126, metadata !DIExpression()), !dbg !138
  call void @llvm.dbg.value(metadata i32 %1, metadata !127, metadata !DIExpression()), !dbg !138
  call void @llvm.dbg.value(metadata ptr %2, metadata !128, metadata !DIExpression()), !dbg !138
  call void @llvm.dbg.value(metadata ptr %3, metadata !129, metadata !DIExpression()), !dbg !138
  call void @llvm.dbg.value(metadata i32 1, metadata !130, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 1, metadata !130, metadata !DIExpression()), !dbg !139
  %5 = icmp sgt i32 %0, 2, !dbg !140
  br i1 %5, label %6, label %21, !dbg !141

6:                                                ; preds = %4
  %7 = add i32 %0, -1
  %8 = add i32 %1, -1
  %9 = icmp sgt i32 %1, 2
  %10 = sub nsw i32 0, %1
  %11 = sext i32 %10 to i64
  %12 = sext i32 %1 to i64
  %13 = sext i32 %1 to i64, !dbg !141
  %14 = zext i32 %7 to i64, !dbg !140
  %15 = zext i32 %8 to i64
  br label %16, !dbg !141

16:                                               ; preds = %6, %22
  %17 = phi i64 [ 1, %6 ], [ %23, %22 ]
  call void @llvm.dbg.value(metadata i64 %17, metadata !130, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 1, metadata !132, metadata !DIExpression()), !dbg !142
  br i1 %9, label %18, label %22, !dbg !143

18:                                               ; preds = %16
  %19 = mul nsw i64 %17, %13
  %20 = getelementptr inbounds float, ptr %2, i64 %19
  br label %25, !dbg !143

21:                                               ; preds = %22, %4
  ret void, !dbg !144

22:                                               ; preds = %25, %16
  %23 = add nuw nsw i64 %17, 1, !dbg !145
  call void @llvm.dbg.value(metadata i64 %23, metadata !130, metadata !DIExpression()), !dbg !139
  %24 = icmp eq i64 %23, %14, !dbg !140
  br i1 %24, label %21, label %16, !dbg !141, !llvm.loop !146

25:                                               ; preds = %18, %25
  %26 = phi i64 [ 1, %18 ], [ %44, %25 ]
  call void @llvm.dbg.value(metadata i64 %26, metadata !132, metadata !DIExpression()), !dbg !142
  %27 = getelementptr inbounds float, ptr %20, i64 %26, !dbg !148
  call void @llvm.dbg.value(metadata ptr %27, metadata !135, metadata !DIExpression()), !dbg !149
  %28 = load float, ptr %27, align 4, !dbg !150, !tbaa !91
  %29 = getelementptr inbounds float, ptr %27, i64 -1, !dbg !151
  %30 = load float, ptr %29, align 4, !dbg !151, !tbaa !91
  %31 = fadd float %28, %30, !dbg !152
  %32 = getelementptr inbounds float, ptr %27, i64 1, !dbg !153
  %33 = load float, ptr %32, align 4, !dbg !153, !tbaa !91
  %34 = fadd float %31, %33, !dbg !154
  %35 = getelementptr inbounds float, ptr %27, i64 %11, !dbg !155
  %36 = load float, ptr %35, align 4, !dbg !155, !tbaa !91
  %37 = fadd float %34, %36, !dbg !156
  %38 = getelementptr inbounds float, ptr %27, i64 %12, !dbg !157
  %39 = load float, ptr %38, align 4, !dbg !157, !tbaa !91
  %40 = fadd float %37, %39, !dbg !158
  %41 = fmul float %40, 0x3FC99999A0000000, !dbg !159
  %42 = add nsw i64 %26, %19, !dbg !160
  %43 = getelementptr inbounds float, ptr %3, i64 %42, !dbg !161
  store float %41, ptr %43, align 4, !dbg !162, !tbaa !91
  %44 = add nuw nsw i64 %26, 1, !dbg !163
  call void @llvm.dbg.value(metadata i64 %44, metadata !132, metadata !DIExpression()), !dbg !142
  %45 = icmp eq i64 %44, %15, !dbg !164
  br i1 %45, label %22, label %25, !dbg !143, !llvm.loop !165
}

; Function Attrs: nofree norecurse nosync nounwind memory(readwrite, inaccessiblemem: none) uwtable
define dso_local i32 @prefix_sum(ptr noundef %0, i32 noundef %1) local_unnamed_addr #3 !dbg !167 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !171, metadata !DIExpression()), !dbg !180
  call void @llvm.dbg.value(metadata i32 %1, metadata !172, metadata !DIExpression()), !dbg !180
  call void @llvm.dbg.value(metadata i32 0, metadata !173, metadata !DIExpression()), !dbg !180
  call void @llvm.dbg.value(metadata ptr %0, metadata !174, metadata !DIExpression()), !dbg !181
  %3 = sext i32 %1 to i64, !dbg !182
  %4 = getelementptr inbounds i32, ptr %0, i64 %3, !dbg !182
  call void @llvm.dbg.value(metadata ptr %4, metadata !176, metadata !DIExpression()), !dbg !181
  call void @llvm.dbg.value(metadata i32 0, metadata !173, metadata !DIExpression()), !dbg !180
  call void @llvm.dbg.value(metadata ptr %0, metadata !174, metadata !DIExpression()), !dbg !181
  %5 = icmp eq i32 %1, 0, !dbg !183
  br i1 %5, label %6, label %8, !dbg !184

6:                                                ; preds = %8, %2
  %7 = phi i32 [ 0, %2 ], [ %12, %8 ], !dbg !180
  ret i32 %7, !dbg !185

8:                                                ; preds = %2, %8
  %9 = phi i32 [ %12, %8 ], [ 0, %2 ]
  %10 = phi ptr [ %13, %8 ], [ %0, %2 ]
  call void @llvm.dbg.value(metadata i32 %9, metadata !173, metadata !DIExpression()), !dbg !180
  call void @llvm.dbg.value(metadata ptr %10, metadata !174, metadata !DIExpression()), !dbg !181
  %11 = load i32, ptr %10, align 4, !dbg !186, !tbaa !38
  call void @llvm.dbg.value(metadata i32 %11, metadata !177, metadata !DIExpression()), !dbg !187
  store i32 %9, ptr %10, align 4, !dbg !188, !tbaa !38
  %12 = add nsw i32 %11, %9, !dbg !189
  call void @llvm.dbg.value(metadata i32 %12, metadata !173, metadata !DIExpression()), !dbg !180
  %13 = getelementptr inbounds i32, ptr %10, i64 1, !dbg !190
  call void @llvm.dbg.value(metadata ptr %13, metadata !174, metadata !DIExpression()), !dbg !181
  %14 = icmp eq ptr %13, %4, !dbg !183
  br i1 %14, label %6, label %8, !dbg !184, !llvm.loop !191
}

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare void @llvm.dbg.value(metadata, metadata, metadata) #4

attributes #0 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { nofree nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #2 = { mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none) }
attributes #3 = { nofree norecurse nosync nounwind memory(readwrite, inaccessiblemem: none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #4 = { nocallback nofree nosync nounwind speculatable willreturn memory(none) }

!llvm.dbg.cu = !{!0}
!llvm.module.flags = !{!2, !3, !4, !5, !6, !7}
!llvm.ident = !{!8}

!0 = distinct !DICompileUnit(language: DW_LANG_C11, file: !1, producer: "Debian clang version 16.0.6 (15~deb12u1)", isOptimized: true, runtimeVersion: 0, emissionKind: FullDebug, splitDebugInlining: false, nameTableKind: None)
!1 = !DIFile(filename: "signals.c", directory: ".", checksumkind: CSK_MD5, checksum: "d0e345656b2f691bcb5f1188985de14e")
!2 = !{i32 7, !"Dwarf Version", i32 5}
!3 = !{i32 2, !"Debug Info Version", i32 3}
!4 = !{i32 1, !"wchar_size", i32 4}
!5 = !{i32 8, !"PIC Level", i32 2}
!6 = !{i32 7, !"PIE Level", i32 2}
!7 = !{i32 7, !"uwtable", i32 2}
!8 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!9 = distinct !DISubprogram(name: "fir", scope: !1, file: !1, line: 5, type: !10, scopeLine: 6, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !16)
!10 = !DISubroutineType(types: !11)
!11 = !{null, !12, !12, !15, !14}
!12 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !13, size: 64)
!13 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !14)
!14 = !DIBasicType(name: "int", size: 32, encoding: DW_ATE_signed)
!15 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !14, size: 64)
!16 = !{!17, !18, !19, !20, !21, !23, !26}
!17 = !DILocalVariable(name: "x", arg: 1, scope: !9, file: !1, line: 5, type: !12)
!18 = !DILocalVariable(name: "h", arg: 2, scope: !9, file: !1, line: 5, type: !12)
!19 = !DILocalVariable(name: "y", arg: 3, scope: !9, file: !1, line: 5, type: !15)
!20 = !DILocalVariable(name: "n", arg: 4, scope: !9, file: !1, line: 5, type: !14)
!21 = !DILocalVariable(name: "i", scope: !22, file: !1, line: 7, type: !14)
!22 = distinct !DILexicalBlock(scope: !9, file: !1, line: 7, column: 5)
!23 = !DILocalVariable(name: "sum", scope: !24, file: !1, line: 8, type: !14)
!24 = distinct !DILexicalBlock(scope: !25, file: !1, line: 7, column: 41)
!25 = distinct !DILexicalBlock(scope: !22, file: !1, line: 7, column: 5)
!26 = !DILocalVariable(name: "t", scope: !27, file: !1, line: 9, type: !14)
!27 = distinct !DILexicalBlock(scope: !24, file: !1, line: 9, column: 9)
!28 = !DILocation(line: 0, scope: !9)
!29 = !DILocation(line: 0, scope: !22)
!30 = !DILocation(line: 7, column: 30, scope: !25)
!31 = !DILocation(line: 7, column: 5, scope: !22)
!32 = !DILocation(line: 0, scope: !27)
!33 = !DILocation(line: 0, scope: !24)
!34 = !DILocation(line: 9, column: 9, scope: !27)
!35 = !DILocation(line: 13, column: 1, scope: !9)
!36 = !DILocation(line: 11, column: 9, scope: !24)
!37 = !DILocation(line: 11, column: 14, scope: !24)
!38 = !{!39, !39, i64 0}
!39 = !{!"int", !40, i64 0}
!40 = !{!"omnipotent char", !41, i64 0}
!41 = !{!"Simple C/C++ TBAA"}
!42 = !DILocation(line: 7, column: 37, scope: !25)
!43 = distinct !{!43, !31, !44, !45, !46}
!44 = !DILocation(line: 12, column: 5, scope: !22)
!45 = !{!"llvm.loop.mustprogress"}
!46 = !{!"llvm.loop.unroll.disable"}
!47 = !DILocation(line: 10, column: 24, scope: !48)
!48 = distinct !DILexicalBlock(scope: !27, file: !1, line: 9, column: 9)
!49 = !DILocation(line: 10, column: 20, scope: !48)
!50 = !DILocation(line: 10, column: 31, scope: !48)
!51 = !DILocation(line: 10, column: 29, scope: !48)
!52 = !DILocation(line: 10, column: 17, scope: !48)
!53 = !DILocation(line: 9, column: 36, scope: !48)
!54 = !DILocation(line: 9, column: 27, scope: !48)
!55 = distinct !{!55, !34, !56, !45, !46}
!56 = !DILocation(line: 10, column: 34, scope: !27)
!57 = distinct !DISubprogram(name: "biquad", scope: !1, file: !1, line: 21, type: !58, scopeLine: 22, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !74)
!58 = !DISubroutineType(types: !59)
!59 = !{null, !60, !71, !73, !14}
!60 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !61, size: 64)
!61 = distinct !DICompositeType(tag: DW_TAG_structure_type, name: "biquad", file: !1, line: 15, size: 224, elements: !62)
!62 = !{!63, !65, !66, !67, !68, !69, !70}
!63 = !DIDerivedType(tag: DW_TAG_member, name: "b0", scope: !61, file: !1, line: 16, baseType: !64, size: 32)
!64 = !DIBasicType(name: "float", size: 32, encoding: DW_ATE_float)
!65 = !DIDerivedType(tag: DW_TAG_member, name: "b1", scope: !61, file: !1, line: 16, baseType: !64, size: 32, offset: 32)
!66 = !DIDerivedType(tag: DW_TAG_member, name: "b2", scope: !61, file: !1, line: 16, baseType: !64, size: 32, offset: 64)
!67 = !DIDerivedType(tag: DW_TAG_member, name: "a1", scope: !61, file: !1, line: 16, baseType: !64, size: 32, offset: 96)
!68 = !DIDerivedType(tag: DW_TAG_member, name: "a2", scope: !61, file: !1, line: 16, baseType: !64, size: 32, offset: 128)
!69 = !DIDerivedType(tag: DW_TAG_member, name: "z1", scope: !61, file: !1, line: 17, baseType: !64, size: 32, offset: 160)
!70 = !DIDerivedType(tag: DW_TAG_member, name: "z2", scope: !61, file: !1, line: 17, baseType: !64, size: 32, offset: 192)
!71 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !72, size: 64)
!72 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !64)
!73 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !64, size: 64)
!74 = !{!75, !76, !77, !78, !79, !81, !84}
!75 = !DILocalVariable(name: "f", arg: 1, scope: !57, file: !1, line: 21, type: !60)
!76 = !DILocalVariable(name: "x", arg: 2, scope: !57, file: !1, line: 21, type: !71)
!77 = !DILocalVariable(name: "y", arg: 3, scope: !57, file: !1, line: 21, type: !73)
!78 = !DILocalVariable(name: "n", arg: 4, scope: !57, file: !1, line: 21, type: !14)
!79 = !DILocalVariable(name: "i", scope: !80, file: !1, line: 23, type: !14)
!80 = distinct !DILexicalBlock(scope: !57, file: !1, line: 23, column: 5)
!81 = !DILocalVariable(name: "in", scope: !82, file: !1, line: 24, type: !64)
!82 = distinct !DILexicalBlock(scope: !83, file: !1, line: 23, column: 33)
!83 = distinct !DILexicalBlock(scope: !80, file: !1, line: 23, column: 5)
!84 = !DILocalVariable(name: "out", scope: !82, file: !1, line: 25, type: !64)
!85 = !DILocation(line: 0, scope: !57)
!86 = !DILocation(line: 0, scope: !80)
!87 = !DILocation(line: 23, column: 23, scope: !83)
!88 = !DILocation(line: 23, column: 5, scope: !80)
!89 = !DILocation(line: 30, column: 1, scope: !57)
!90 = !DILocation(line: 24, column: 20, scope: !82)
!91 = !{!92, !92, i64 0}
!92 = !{!"float", !40, i64 0}
!93 = !DILocation(line: 0, scope: !82)
!94 = !DILocation(line: 25, column: 24, scope: !82)
!95 = !{!96, !92, i64 0}
!96 = !{!"biquad", !92, i64 0, !92, i64 4, !92, i64 8, !92, i64 12, !92, i64 16, !92, i64 20, !92, i64 24}
!97 = !DILocation(line: 25, column: 37, scope: !82)
!98 = !{!96, !92, i64 20}
!99 = !DILocation(line: 25, column: 32, scope: !82)
!100 = !DILocation(line: 26, column: 20, scope: !82)
!101 = !{!96, !92, i64 4}
!102 = !DILocation(line: 26, column: 33, scope: !82)
!103 = !{!96, !92, i64 12}
!104 = !DILocation(line: 26, column: 28, scope: !82)
!105 = !DILocation(line: 26, column: 47, scope: !82)
!106 = !{!96, !92, i64 24}
!107 = !DILocation(line: 26, column: 42, scope: !82)
!108 = !DILocation(line: 26, column: 15, scope: !82)
!109 = !DILocation(line: 27, column: 20, scope: !82)
!110 = !{!96, !92, i64 8}
!111 = !DILocation(line: 27, column: 33, scope: !82)
!112 = !{!96, !92, i64 16}
!113 = !DILocation(line: 27, column: 28, scope: !82)
!114 = !DILocation(line: 27, column: 15, scope: !82)
!115 = !DILocation(line: 28, column: 9, scope: !82)
!116 = !DILocation(line: 28, column: 14, scope: !82)
!117 = !DILocation(line: 23, column: 29, scope: !83)
!118 = distinct !{!118, !88, !119, !45, !46}
!119 = !DILocation(line: 29, column: 5, scope: !80)
!120 = distinct !DISubprogram(name: "jacobi2d", scope: !1, file: !1, line: 33, type: !121, scopeLine: 34, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !125)
!121 = !DISubroutineType(types: !122)
!122 = !{null, !14, !14, !123, !124}
!123 = !DIDerivedType(tag: DW_TAG_restrict_type, baseType: !71)
!124 = !DIDerivedType(tag: DW_TAG_restrict_type, baseType: !73)
!125 = !{!126, !127, !128, !129, !130, !132, !135}
!126 = !DILocalVariable(name: "h", arg: 1, scope: !120, file: !1, line: 33, type: !14)
!127 = !DILocalVariable(name: "w", arg: 2, scope: !120, file: !1, line: 33, type: !14)
!128 = !DILocalVariable(name: "in", arg: 3, scope: !120, file: !1, line: 33, type: !123)
!129 = !DILocalVariable(name: "out", arg: 4, scope: !120, file: !1, line: 33, type: !124)
!130 = !DILocalVariable(name: "y", scope: !131, file: !1, line: 35, type: !14)
!131 = distinct !DILexicalBlock(scope: !120, file: !1, line: 35, column: 5)
!132 = !DILocalVariable(name: "x", scope: !133, file: !1, line: 36, type: !14)
!133 = distinct !DILexicalBlock(scope: !134, file: !1, line: 36, column: 9)
!134 = distinct !DILexicalBlock(scope: !131, file: !1, line: 35, column: 5)
!135 = !DILocalVariable(name: "p", scope: !136, file: !1, line: 37, type: !71)
!136 = distinct !DILexicalBlock(scope: !137, file: !1, line: 36, column: 41)
!137 = distinct !DILexicalBlock(scope: !133, file: !1, line: 36, column: 9)
!138 = !DILocation(line: 0, scope: !120)
!139 = !DILocation(line: 0, scope: !131)
!140 = !DILocation(line: 35, column: 23, scope: !134)
!141 = !DILocation(line: 35, column: 5, scope: !131)
!142 = !DILocation(line: 0, scope: !133)
!143 = !DILocation(line: 36, column: 9, scope: !133)
!144 = !DILocation(line: 40, column: 1, scope: !120)
!145 = !DILocation(line: 35, column: 33, scope: !134)
!146 = distinct !{!146, !141, !147, !45, !46}
!147 = !DILocation(line: 39, column: 9, scope: !131)
!148 = !DILocation(line: 37, column: 41, scope: !136)
!149 = !DILocation(line: 0, scope: !136)
!150 = !DILocation(line: 38, column: 38, scope: !136)
!151 = !DILocation(line: 38, column: 45, scope: !136)
!152 = !DILocation(line: 38, column: 43, scope: !136)
!153 = !DILocation(line: 38, column: 53, scope: !136)
!154 = !DILocation(line: 38, column: 51, scope: !136)
!155 = !DILocation(line: 38, column: 60, scope: !136)
!156 = !DILocation(line: 38, column: 58, scope: !136)
!157 = !DILocation(line: 38, column: 68, scope: !136)
!158 = !DILocation(line: 38, column: 66, scope: !136)
!159 = !DILocation(line: 38, column: 35, scope: !136)
!160 = !DILocation(line: 38, column: 23, scope: !136)
!161 = !DILocation(line: 38, column: 13, scope: !136)
!162 = !DILocation(line: 38, column: 28, scope: !136)
!163 = !DILocation(line: 36, column: 37, scope: !137)
!164 = !DILocation(line: 36, column: 27, scope: !137)
!165 = distinct !{!165, !143, !166, !45, !46}
!166 = !DILocation(line: 39, column: 9, scope: !133)
!167 = distinct !DISubprogram(name: "prefix_sum", scope: !1, file: !1, line: 43, type: !168, scopeLine: 44, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !170)
!168 = !DISubroutineType(types: !169)
!169 = !{!14, !15, !14}
!170 = !{!171, !172, !173, !174, !176, !177}
!171 = !DILocalVariable(name: "x", arg: 1, scope: !167, file: !1, line: 43, type: !15)
!172 = !DILocalVariable(name: "n", arg: 2, scope: !167, file: !1, line: 43, type: !14)
!173 = !DILocalVariable(name: "sum", scope: !167, file: !1, line: 45, type: !14)
!174 = !DILocalVariable(name: "p", scope: !175, file: !1, line: 46, type: !15)
!175 = distinct !DILexicalBlock(scope: !167, file: !1, line: 46, column: 5)
!176 = !DILocalVariable(name: "end", scope: !175, file: !1, line: 46, type: !15)
!177 = !DILocalVariable(name: "value", scope: !178, file: !1, line: 47, type: !14)
!178 = distinct !DILexicalBlock(scope: !179, file: !1, line: 46, column: 51)
!179 = distinct !DILexicalBlock(scope: !175, file: !1, line: 46, column: 5)
!180 = !DILocation(line: 0, scope: !167)
!181 = !DILocation(line: 0, scope: !175)
!182 = !DILocation(line: 46, column: 31, scope: !175)
!183 = !DILocation(line: 46, column: 38, scope: !179)
!184 = !DILocation(line: 46, column: 5, scope: !175)
!185 = !DILocation(line: 51, column: 5, scope: !167)
!186 = !DILocation(line: 47, column: 21, scope: !178)
!187 = !DILocation(line: 0, scope: !178)
!188 = !DILocation(line: 48, column: 12, scope: !178)
!189 = !DILocation(line: 49, column: 13, scope: !178)
!190 = !DILocation(line: 46, column: 47, scope: !179)
!191 = distinct !{!191, !184, !192, !45, !46}
!192 = !DILocation(line: 50, column: 5, scope: !175)
