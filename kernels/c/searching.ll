; ModuleID = 'searching.c'
source_filename = "searching.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @insertion_sort(ptr nocapture noundef %0, i32 noundef %1) local_unnamed_addr #0 !dbg !9 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !15, metadata !DIExpression()), !dbg !23
  call void @llvm.dbg.value(metadata i32 %1, metadata !16, metadata !DIExpression()), !dbg !23
  call void @llvm.dbg.value(metadata i32 1, metadata !17, metadata !DIExpression()), !dbg !24
  %3 = icmp sgt i32 %1, 1, !dbg !25
  br i1 %3, label %4, label %6, !dbg !26

4:                                                ; preds = %2
  %5 = zext i32 %1 to i64, !dbg !25
  br label %7, !dbg !26

6:                                                ; preds = %21, %2
  ret void, !dbg !27

7:                                                ; preds = %4, %21
  %8 = phi i64 [ 1, %4 ], [ %26, %21 ]
  call void @llvm.dbg.value(metadata i64 %8, metadata !17, metadata !DIExpression()), !dbg !24
  %9 = getelementptr inbounds i32, ptr %0, i64 %8, !dbg !28
  %10 = load i32, ptr %9, align 4, !dbg !28, !tbaa !29
  call void @llvm.dbg.value(metadata i32 %10, metadata !19, metadata !DIExpression()), !dbg !33
  call void @llvm.dbg.value(metadata i64 %8, metadata !22, metadata !DIExpression(DW_OP_constu, 1, DW_OP_minus, DW_OP_stack_value)), !dbg !33
  call void @llvm.dbg.value(metadata i64 %8, metadata !22, metadata !DIExpression(DW_OP_constu, 1, DW_OP_minus, DW_OP_stack_value)), !dbg !33
  br label %11, !dbg !34

11:                                               ; preds = %7, %18
  %12 = phi i64 [ %8, %7 ], [ %13, %18 ]
  %13 = add nsw i64 %12, -1, !dbg !33
  %14 = and i64 %13, 4294967295
  %15 = getelementptr inbounds i32, ptr %0, i64 %14, !dbg !35
  %16 = load i32, ptr %15, align 4, !dbg !35, !tbaa !29
  %17 = icmp sgt i32 %16, %10, !dbg !36
  br i1 %17, label %18, label %21, !dbg !37

18:                                               ; preds = %11
  %19 = getelementptr inbounds i32, ptr %0, i64 %12, !dbg !38
  store i32 %16, ptr %19, align 4, !dbg !40, !tbaa !29
  call void @llvm.dbg.value(metadata i64 %13, metadata !22, metadata !DIExpression(DW_OP_constu, 1, DW_OP_minus, DW_OP_stack_value)), !dbg !33
  call void @llvm.dbg.value(metadata i64 %13, metadata !22, metadata !DIExpression(DW_OP_constu, 1, DW_OP_minus, DW_OP_stack_value)), !dbg !33
  %20 = icmp sgt i64 %12, 1, !dbg !41
  br i1 %20, label %11, label %21, !dbg !34, !llvm.loop !42

21:                                               ; preds = %18, %11
  %22 = phi i64 [ 0, %18 ], [ %12, %11 ]
  %23 = shl i64 %22, 32, !dbg !46
  %24 = ashr exact i64 %23, 32, !dbg !46
  %25 = getelementptr inbounds i32, ptr %0, i64 %24, !dbg !46
  store i32 %10, ptr %25, align 4, !dbg !47, !tbaa !29
  %26 = add nuw nsw i64 %8, 1, !dbg !48
  call void @llvm.dbg.value(metadata i64 %26, metadata !17, metadata !DIExpression()), !dbg !24
  %27 = icmp eq i64 %26, %5, !dbg !25
  br i1 %27, label %6, label %7, !dbg !26, !llvm.loop !49
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @bubble_sort(ptr nocapture noundef %0, i32 noundef %1) local_unnamed_addr #0 !dbg !51 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !53, metadata !DIExpression()), !dbg !63
  call void @llvm.dbg.value(metadata i32 %1, metadata !54, metadata !DIExpression()), !dbg !63
  call void @llvm.dbg.value(metadata i32 1, metadata !55, metadata !DIExpression()), !dbg !63
  %3 = icmp sgt i32 %1, 1
  call void @llvm.dbg.value(metadata i32 1, metadata !55, metadata !DIExpression()), !dbg !63
  %4 = add i32 %1, -1, !dbg !64
  %5 = zext i32 %4 to i64
  br label %9, !dbg !64

6:                                                ; preds = %21, %9
  %7 = phi i32 [ 0, %9 ], [ %22, %21 ], !dbg !65
  call void @llvm.dbg.value(metadata i32 %7, metadata !55, metadata !DIExpression()), !dbg !63
  %8 = icmp eq i32 %7, 0, !dbg !64
  br i1 %8, label %25, label %9, !dbg !64, !llvm.loop !66

9:                                                ; preds = %2, %6
  call void @llvm.dbg.value(metadata i32 0, metadata !55, metadata !DIExpression()), !dbg !63
  call void @llvm.dbg.value(metadata i32 0, metadata !56, metadata !DIExpression()), !dbg !68
  br i1 %3, label %10, label %6, !dbg !69

10:                                               ; preds = %9, %21
  %11 = phi i64 [ %14, %21 ], [ 0, %9 ]
  %12 = phi i64 [ %23, %21 ], [ 1, %9 ]
  %13 = phi i32 [ %22, %21 ], [ 0, %9 ]
  %14 = add nuw nsw i64 %11, 1
  call void @llvm.dbg.value(metadata i32 %13, metadata !55, metadata !DIExpression()), !dbg !63
  call void @llvm.dbg.value(metadata i64 %11, metadata !56, metadata !DIExpression()), !dbg !68
  %15 = getelementptr inbounds i32, ptr %0, i64 %11, !dbg !70
  %16 = load i32, ptr %15, align 4, !dbg !70, !tbaa !29
  %17 = getelementptr inbounds i32, ptr %0, i64 %12, !dbg !71
  %18 = load i32, ptr %17, align 4, !dbg !71, !tbaa !29
  %19 = icmp sgt i32 %16, %18, !dbg !72
  br i1 %19, label %20, label %21, !dbg !73

20:                                               ; preds = %10
  call void @llvm.dbg.value(metadata i32 %16, metadata !59, metadata !DIExpression()), !dbg !74
  store i32 %18, ptr %15, align 4, !dbg !75, !tbaa !29
  store i32 %16, ptr %17, align 4, !dbg !76, !tbaa !29
  call void @llvm.dbg.value(metadata i32 1, metadata !55, metadata !DIExpression()), !dbg !63
  br label %21, !dbg !77

21:                                               ; preds = %10, %20
  %22 = phi i32 [ 1, %20 ], [ %13, %10 ], !dbg !65
  call void @llvm.dbg.value(metadata i32 %22, metadata !55, metadata !DIExpression()), !dbg !63
  call void @llvm.dbg.value(metadata i64 %12, metadata !56, metadata !DIExpression()), !dbg !68
  %23 = add nuw nsw i64 %12, 1, !dbg !78
  %24 = icmp eq i64 %14, %5, !dbg !79
  br i1 %24, label %6, label %10, !dbg !69, !llvm.loop !80

25:                                               ; preds = %6
  ret void, !dbg !82
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @binary_search(ptr nocapture noundef readonly %0, i32 noundef %1, i32 noundef %2) local_unnamed_addr #1 !dbg !83 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !89, metadata !DIExpression()), !dbg !96
  call void @llvm.dbg.value(metadata i32 %1, metadata !90, metadata !DIExpression()), !dbg !96
  call void @llvm.dbg.value(metadata i32 %2, metadata !91, metadata !DIExpression()), !dbg !96
  call void @llvm.dbg.value(metadata i32 0, metadata !92, metadata !DIExpression()), !dbg !96
  %4 = add nsw i32 %1, -1, !dbg !97
  call void @llvm.dbg.value(metadata i32 %4, metadata !93, metadata !DIExpression()), !dbg !96
  br label %5, !dbg !98

5:                                                ; preds = %24, %3
  %6 = phi i32 [ 0, %3 ], [ %25, %24 ], !dbg !99
  %7 = phi i32 [ %4, %3 ], [ %26, %24 ], !dbg !100
  %8 = phi i32 [ undef, %3 ], [ %27, %24 ]
  call void @llvm.dbg.value(metadata i32 %7, metadata !93, metadata !DIExpression()), !dbg !96
  call void @llvm.dbg.value(metadata i32 %6, metadata !92, metadata !DIExpression()), !dbg !96
  %9 = icmp slt i32 %7, %6, !dbg !101
  br i1 %9, label %28, label %10, !dbg !98

10:                                               ; preds = %5
  %11 = sub nsw i32 %7, %6, !dbg !102
  %12 = sdiv i32 %11, 2, !dbg !103
  %13 = add nsw i32 %12, %6, !dbg !104
  call void @llvm.dbg.value(metadata i32 %13, metadata !94, metadata !DIExpression()), !dbg !105
  %14 = sext i32 %13 to i64, !dbg !106
  %15 = getelementptr inbounds i32, ptr %0, i64 %14, !dbg !106
  %16 = load i32, ptr %15, align 4, !dbg !106, !tbaa !29
  %17 = icmp eq i32 %16, %2, !dbg !108
  br i1 %17, label %24, label %18, !dbg !109

18:                                               ; preds = %10
  %19 = icmp slt i32 %16, %2, !dbg !110
  %20 = add nsw i32 %13, 1, !dbg !112
  %21 = add nsw i32 %13, -1, !dbg !112
  %22 = select i1 %19, i32 %20, i32 %6, !dbg !112
  %23 = select i1 %19, i32 %7, i32 %21, !dbg !112
  call void @llvm.dbg.value(metadata i32 %23, metadata !93, metadata !DIExpression()), !dbg !96
  call void @llvm.dbg.value(metadata i32 %22, metadata !92, metadata !DIExpression()), !dbg !96
  br label %24, !dbg !113

24:                                               ; preds = %10, %18
  %25 = phi i32 [ %22, %18 ], [ %6, %10 ], !dbg !96
  %26 = phi i32 [ %23, %18 ], [ %7, %10 ], !dbg !100
  %27 = phi i32 [ %8, %18 ], [ %13, %10 ]
  call void @llvm.dbg.value(metadata i32 %26, metadata !93, metadata !DIExpression()), !dbg !96
  call void @llvm.dbg.value(metadata i32 %25, metadata !92, metadata !DIExpression()), !dbg !96
  br i1 %17, label %28, label %5, !llvm.loop !114

28:                                               ; preds = %5, %24
  %29 = phi i32 [ %27, %24 ], [ -1, %5 ], !dbg !96
  ret i32 %29, !dbg !115
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @partition(ptr nocapture noundef %0, i32 noundef %1) local_unnamed_addr #0 !dbg !116 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !120, metadata !DIExpression()), !dbg !130
  call void @llvm.dbg.value(metadata i32 %1, metadata !121, metadata !DIExpression()), !dbg !130
  %3 = add nsw i32 %1, -1, !dbg !131
  %4 = sext i32 %3 to i64, !dbg !132
  %5 = getelementptr inbounds i32, ptr %0, i64 %4, !dbg !132
  %6 = load i32, ptr %5, align 4, !dbg !132, !tbaa !29
  call void @llvm.dbg.value(metadata i32 %6, metadata !122, metadata !DIExpression()), !dbg !130
  call void @llvm.dbg.value(metadata i32 0, metadata !123, metadata !DIExpression()), !dbg !130
  call void @llvm.dbg.value(metadata i32 0, metadata !124, metadata !DIExpression()), !dbg !133
  %7 = icmp sgt i32 %1, 1, !dbg !134
  br i1 %7, label %8, label %10, !dbg !135

8:                                                ; preds = %2
  %9 = zext i32 %3 to i64, !dbg !134
  br label %15, !dbg !135

10:                                               ; preds = %26, %2
  %11 = phi i32 [ 0, %2 ], [ %27, %26 ], !dbg !130
  %12 = sext i32 %11 to i64, !dbg !136
  %13 = getelementptr inbounds i32, ptr %0, i64 %12, !dbg !136
  %14 = load i32, ptr %13, align 4, !dbg !136, !tbaa !29
  store i32 %14, ptr %5, align 4, !dbg !137, !tbaa !29
  store i32 %6, ptr %13, align 4, !dbg !138, !tbaa !29
  ret i32 %11, !dbg !139

15:                                               ; preds = %8, %26
  %16 = phi i64 [ 0, %8 ], [ %28, %26 ]
  %17 = phi i32 [ 0, %8 ], [ %27, %26 ]
  call void @llvm.dbg.value(metadata i32 %17, metadata !123, metadata !DIExpression()), !dbg !130
  call void @llvm.dbg.value(metadata i64 %16, metadata !124, metadata !DIExpression()), !dbg !133
  %18 = getelementptr inbounds i32, ptr %0, i64 %16, !dbg !140
  %19 = load i32, ptr %18, align 4, !dbg !140, !tbaa !29
  %20 = icmp slt i32 %19, %6, !dbg !141
  br i1 %20, label %21, label %26, !dbg !142

21:                                               ; preds = %15
  %22 = sext i32 %17 to i64, !dbg !143
  %23 = getelementptr inbounds i32, ptr %0, i64 %22, !dbg !143
  %24 = load i32, ptr %23, align 4, !dbg !143, !tbaa !29
  call void @llvm.dbg.value(metadata i32 %24, metadata !126, metadata !DIExpression()), !dbg !144
  store i32 %19, ptr %23, align 4, !dbg !145, !tbaa !29
  store i32 %24, ptr %18, align 4, !dbg !146, !tbaa !29
  %25 = add nsw i32 %17, 1, !dbg !147
  call void @llvm.dbg.value(metadata i32 %25, metadata !123, metadata !DIExpression()), !dbg !130
  br label %26, !dbg !148

26:                                               ; preds = %15, %21
  %27 = phi i32 [ %25, %21 ], [ %17, %15 ], !dbg !130
  call void @llvm.dbg.value(metadata i32 %27, metadata !123, metadata !DIExpression()), !dbg !130
  %28 = add nuw nsw i64 %16, 1, !dbg !149
  call void @llvm.dbg.value(metadata i64 %28, metadata !124, metadata !DIExpression()), !dbg !133
  %29 = icmp eq i64 %28, %9, !dbg !134
  br i1 %29, label %10, label %15, !dbg !135, !llvm.loop !150
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @find(ptr nocapture noundef readonly %0, i32 noundef %1, ptr nocapture noundef readonly %2, i32 noundef %3) local_unnamed_addr #1 !dbg !152 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !156, metadata !DIExpression()), !dbg !165
  call void @llvm.dbg.value(metadata i32 %1, metadata !157, metadata !DIExpression()), !dbg !165
  call void @llvm.dbg.value(metadata ptr %2, metadata !158, metadata !DIExpression()), !dbg !165
  call void @llvm.dbg.value(metadata i32 %3, metadata !159, metadata !DIExpression()), !dbg !165
  call void @llvm.dbg.value(metadata i32 0, metadata !160, metadata !DIExpression()), !dbg !166
  %5 = icmp sgt i32 %3, %1, !dbg !167
  br i1 %5, label %35, label %6, !dbg !168

6:                                                ; preds = %4
  %7 = icmp sgt i32 %3, 0
  %8 = zext i32 %3 to i64
  br label %14, !dbg !168

9:                                                ; preds = %30
  %10 = add nuw i64 %15, 1, !dbg !169
  call void @llvm.dbg.value(metadata i64 %10, metadata !160, metadata !DIExpression()), !dbg !166
  call void @llvm.dbg.value(metadata i64 %15, metadata !160, metadata !DIExpression(DW_OP_plus_uconst, 1, DW_OP_stack_value)), !dbg !166
  %11 = trunc i64 %10 to i32, !dbg !170
  %12 = add nsw i32 %11, %3, !dbg !170
  %13 = icmp sgt i32 %12, %1, !dbg !167
  br i1 %13, label %35, label %14, !dbg !168, !llvm.loop !171

14:                                               ; preds = %6, %9
  %15 = phi i64 [ 0, %6 ], [ %10, %9 ]
  %16 = phi i32 [ undef, %6 ], [ %34, %9 ]
  call void @llvm.dbg.value(metadata i64 %15, metadata !160, metadata !DIExpression()), !dbg !166
  call void @llvm.dbg.value(metadata i32 0, metadata !162, metadata !DIExpression()), !dbg !173
  br i1 %7, label %17, label %30, !dbg !174

17:                                               ; preds = %14, %25
  %18 = phi i64 [ %26, %25 ], [ 0, %14 ]
  call void @llvm.dbg.value(metadata i64 %18, metadata !162, metadata !DIExpression()), !dbg !173
  %19 = add nuw nsw i64 %18, %15, !dbg !175
  %20 = getelementptr inbounds i32, ptr %0, i64 %19, !dbg !176
  %21 = load i32, ptr %20, align 4, !dbg !176, !tbaa !29
  %22 = getelementptr inbounds i32, ptr %2, i64 %18, !dbg !177
  %23 = load i32, ptr %22, align 4, !dbg !177, !tbaa !29
  %24 = icmp eq i32 %21, %23, !dbg !178
  br i1 %24, label %25, label %28, !dbg !179

25:                                               ; preds = %17
  %26 = add nuw nsw i64 %18, 1, !dbg !180
  call void @llvm.dbg.value(metadata i64 %26, metadata !162, metadata !DIExpression()), !dbg !173
  %27 = icmp eq i64 %26, %8, !dbg !181
  br i1 %27, label %30, label %17, !dbg !174, !llvm.loop !182

28:                                               ; preds = %17
  %29 = trunc i64 %18 to i32, !dbg !179
  br label %30, !dbg !183

30:                                               ; preds = %28, %25, %14
  %31 = phi i32 [ 0, %14 ], [ %29, %28 ], [ %3, %25 ], !dbg !173
  %32 = icmp eq i32 %31, %3, !dbg !183
  %33 = trunc i64 %15 to i32, !dbg !185
  %34 = select i1 %32, i32 %33, i32 %16, !dbg !185
  call void @llvm.dbg.value(metadata i64 %15, metadata !160, metadata !DIExpression(DW_OP_plus_uconst, 1, DW_OP_stack_value)), !dbg !166
  br i1 %32, label %35, label %9

35:                                               ; preds = %30, %9, %4
  %36 = phi i32 [ -1, %4 ], [ %34, %30 ], [ -1, %9 ]
  ret i32 %36, !dbg !186
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @floyd_warshall(i32 noundef %0, ptr nocapture noundef %1) local_unnamed_addr #0 !dbg !187 {
  call void @llvm.dbg.value(metadata i32 %0, metadata !195, metadata !DIExpression()), !dbg !205
  call void @llvm.dbg.value(metadata ptr %1, metadata !196, metadata !DIExpression()), !dbg !205
  %3 = zext i32 %0 to i64
  call void @llvm.dbg.value(metadata i32 0, metadata !197, metadata !DIExpression()), !dbg !206
  %4 = icmp sgt i32 %0, 0, !dbg !207
  br i1 %4, label %5, label %13, !dbg !208

5:                                                ; preds = %2
  %6 = zext i32 %0 to i64, !dbg !207
  %7 = zext i32 %0 to i64
  %8 = zext i32 %0 to i64
  br label %9, !dbg !208

9:                                                ; preds = %5, %19
  %10 = phi i64 [ 0, %5 ], [ %20, %19 ]
  call void @llvm.dbg.value(metadata i64 %10, metadata !197, metadata !DIExpression()), !dbg !206
  call void @llvm.dbg.value(metadata i32 0, metadata !199, metadata !DIExpression()), !dbg !209
  %11 = mul nuw nsw i64 %10, %3
  %12 = getelementptr inbounds i32, ptr %1, i64 %11
  br label %14, !dbg !210

13:                                               ; preds = %19, %2
  ret void, !dbg !211

14:                                               ; preds = %9, %22
  %15 = phi i64 [ 0, %9 ], [ %23, %22 ]
  call void @llvm.dbg.value(metadata i64 %15, metadata !199, metadata !DIExpression()), !dbg !209
  call void @llvm.dbg.value(metadata i32 0, metadata !202, metadata !DIExpression()), !dbg !212
  %16 = mul nuw nsw i64 %15, %3
  %17 = getelementptr inbounds i32, ptr %1, i64 %16
  %18 = getelementptr inbounds i32, ptr %17, i64 %10
  br label %25, !dbg !213

19:                                               ; preds = %22
  %20 = add nuw nsw i64 %10, 1, !dbg !214
  call void @llvm.dbg.value(metadata i64 %20, metadata !197, metadata !DIExpression()), !dbg !206
  %21 = icmp eq i64 %20, %6, !dbg !207
  br i1 %21, label %13, label %9, !dbg !208, !llvm.loop !215

22:                                               ; preds = %35
  %23 = add nuw nsw i64 %15, 1, !dbg !217
  call void @llvm.dbg.value(metadata i64 %23, metadata !199, metadata !DIExpression()), !dbg !209
  %24 = icmp eq i64 %23, %7, !dbg !218
  br i1 %24, label %19, label %14, !dbg !210, !llvm.loop !219

25:                                               ; preds = %14, %35
  %26 = phi i64 [ 0, %14 ], [ %36, %35 ]
  call void @llvm.dbg.value(metadata i64 %26, metadata !202, metadata !DIExpression()), !dbg !212
  %27 = load i32, ptr %18, align 4, !dbg !221, !tbaa !29
  %28 = getelementptr inbounds i32, ptr %12, i64 %26, !dbg !224
  %29 = load i32, ptr %28, align 4, !dbg !224, !tbaa !29
  %30 = add nsw i32 %29, %27, !dbg !225
  %31 = getelementptr inbounds i32, ptr %17, i64 %26, !dbg !226
  %32 = load i32, ptr %31, align 4, !dbg !226, !tbaa !29
  %33 = icmp slt i32 %30, %32, !dbg !227
  br i1 %33, label %34, label %35, !dbg !228

34:                                               ; preds = %25
  store i32 %30, ptr %31, align 4, !dbg !229, !tbaa !29
  br label %35, !dbg !230

35:                                               ; preds = %25, %34
  %36 = add nuw nsw i64 %26, 1, !dbg !231
  call void @llvm.dbg.value(metadata i64 %36, metadata !202, metadata !DIExpression()), !dbg !212
  %37 = icmp eq i64 %36, %8, !dbg !232
  br i1 %37, label %22, label %25, !dbg !213, !llvm.loop !233
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @count_ends(ptr nocapture noundef readonly %0, i32 noundef %1, ptr nocapture noundef %2) local_unnamed_addr #0 !dbg !235 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !239, metadata !DIExpression()), !dbg !244
  call void @llvm.dbg.value(metadata i32 %1, metadata !240, metadata !DIExpression()), !dbg !244
  call void @llvm.dbg.value(metadata ptr %2, metadata !241, metadata !DIExpression()), !dbg !244
  call void @llvm.dbg.value(metadata i32 1, metadata !242, metadata !DIExpression()), !dbg !245
  %4 = icmp sgt i32 %1, 1, !dbg !246
  br i1 %4, label %5, label %10, !dbg !248

5:                                                ; preds = %3
  %6 = getelementptr inbounds i32, ptr %2, i64 2
  %7 = getelementptr inbounds i32, ptr %2, i64 1
  %8 = getelementptr inbounds i32, ptr %2, i64 3
  %9 = zext i32 %1 to i64, !dbg !246
  br label %11, !dbg !248

10:                                               ; preds = %28, %3
  ret void, !dbg !249

11:                                               ; preds = %5, %28
  %12 = phi i64 [ 1, %5 ], [ %29, %28 ]
  call void @llvm.dbg.value(metadata i64 %12, metadata !242, metadata !DIExpression()), !dbg !245
  %13 = add nsw i64 %12, -1, !dbg !250
  %14 = getelementptr inbounds i32, ptr %0, i64 %13, !dbg !253
  %15 = load i32, ptr %14, align 4, !dbg !253, !tbaa !29
  %16 = icmp slt i32 %15, 97, !dbg !254
  br i1 %16, label %28, label %17, !dbg !255

17:                                               ; preds = %11
  %18 = getelementptr inbounds i32, ptr %0, i64 %12, !dbg !256
  %19 = load i32, ptr %18, align 4, !dbg !256, !tbaa !29
  switch i32 %19, label %22 [
    i32 32, label %24
    i32 44, label %20
    i32 46, label %21
  ], !dbg !257

20:                                               ; preds = %17
  br label %24, !dbg !258

21:                                               ; preds = %17
  br label %24, !dbg !260

22:                                               ; preds = %17
  %23 = icmp slt i32 %19, 97, !dbg !261
  br i1 %23, label %24, label %28, !dbg !263

24:                                               ; preds = %22, %17, %21, %20
  %25 = phi ptr [ %7, %20 ], [ %6, %21 ], [ %2, %17 ], [ %8, %22 ]
  %26 = load i32, ptr %25, align 4, !dbg !264, !tbaa !29
  %27 = add nsw i32 %26, 1, !dbg !264
  store i32 %27, ptr %25, align 4, !dbg !264, !tbaa !29
  br label %28, !dbg !265

28:                                               ; preds = %24, %22, %11
  %29 = add nuw nsw i64 %12, 1, !dbg !265
  call void @llvm.dbg.value(metadata i64 %29, metadata !242, metadata !DIExpression()), !dbg !245
  %30 = icmp eq i64 %29, %9, !dbg !246
  br i1 %30, label %10, label %11, !dbg !248, !llvm.loop !266
}

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare void @llvm.dbg.value(metadata, metadata, metadata) #2

attributes #0 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { nofree norecurse nosync nounwind memory(argmem: read) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #2 = { nocallback nofree nosync nounwind speculatable willreturn memory(none) }

!llvm.dbg.cu = !{!0}
!llvm.module.flags = !{!2, !3, !4, !5, !6, !7}
!llvm.ident = !{!8}

!0 = distinct !DICompileUnit(language: DW_LANG_C11, file: !1, producer: "Debian clang version 16.0.6 (15~deb12u1)", isOptimized: true, runtimeVersion: 0, emissionKind: FullDebug, splitDebugInlining: false, nameTableKind: None)
!1 = !DIFile(filename: "searching.c", directory: ".", checksumkind: CSK_MD5, checksum: "8eced3516013d5b72e556a916ff0099d")
!2 = !{i32 7, !"Dwarf Version", i32 5}
!3 = !{i32 2, !"Debug Info Version", i32 3}
!4 = !{i32 1, !"wchar_size", i32 4}
!5 = !{i32 8, !"PIC Level", i32 2}
!6 = !{i32 7, !"PIE Level", i32 2}
!7 = !{i32 7, !"uwtable", i32 2}
!8 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!9 = distinct !DISubprogram(name: "insertion_sort", scope: !1, file: !1, line: 3, type: !10, scopeLine: 4, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !14)
!10 = !DISubroutineType(types: !11)
!11 = !{null, !12, !13}
!12 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !13, size: 64)
!13 = !DIBasicType(name: "int", size: 32, encoding: DW_ATE_signed)
!14 = !{!15, !16, !17, !19, !22}
!15 = !DILocalVariable(name: "a", arg: 1, scope: !9, file: !1, line: 3, type: !12)
!16 = !DILocalVariable(name: "n", arg: 2, scope: !9, file: !1, line: 3, type: !13)
!17 = !DILocalVariable(name: "i", scope: !18, file: !1, line: 5, type: !13)
!18 = distinct !DILexicalBlock(scope: !9, file: !1, line: 5, column: 5)
!19 = !DILocalVariable(name: "key", scope: !20, file: !1, line: 6, type: !13)
!20 = distinct !DILexicalBlock(scope: !21, file: !1, line: 5, column: 33)
!21 = distinct !DILexicalBlock(scope: !18, file: !1, line: 5, column: 5)
!22 = !DILocalVariable(name: "j", scope: !20, file: !1, line: 6, type: !13)
!23 = !DILocation(line: 0, scope: !9)
!24 = !DILocation(line: 0, scope: !18)
!25 = !DILocation(line: 5, column: 23, scope: !21)
!26 = !DILocation(line: 5, column: 5, scope: !18)
!27 = !DILocation(line: 13, column: 1, scope: !9)
!28 = !DILocation(line: 6, column: 19, scope: !20)
!29 = !{!30, !30, i64 0}
!30 = !{!"int", !31, i64 0}
!31 = !{!"omnipotent char", !32, i64 0}
!32 = !{!"Simple C/C++ TBAA"}
!33 = !DILocation(line: 0, scope: !20)
!34 = !DILocation(line: 7, column: 23, scope: !20)
!35 = !DILocation(line: 7, column: 26, scope: !20)
!36 = !DILocation(line: 7, column: 31, scope: !20)
!37 = !DILocation(line: 7, column: 9, scope: !20)
!38 = !DILocation(line: 8, column: 13, scope: !39)
!39 = distinct !DILexicalBlock(scope: !20, file: !1, line: 7, column: 38)
!40 = !DILocation(line: 8, column: 22, scope: !39)
!41 = !DILocation(line: 7, column: 18, scope: !20)
!42 = distinct !{!42, !37, !43, !44, !45}
!43 = !DILocation(line: 10, column: 9, scope: !20)
!44 = !{!"llvm.loop.mustprogress"}
!45 = !{!"llvm.loop.unroll.disable"}
!46 = !DILocation(line: 11, column: 9, scope: !20)
!47 = !DILocation(line: 11, column: 18, scope: !20)
!48 = !DILocation(line: 5, column: 29, scope: !21)
!49 = distinct !{!49, !26, !50, !44, !45}
!50 = !DILocation(line: 12, column: 5, scope: !18)
!51 = distinct !DISubprogram(name: "bubble_sort", scope: !1, file: !1, line: 15, type: !10, scopeLine: 16, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !52)
!52 = !{!53, !54, !55, !56, !59}
!53 = !DILocalVariable(name: "a", arg: 1, scope: !51, file: !1, line: 15, type: !12)
!54 = !DILocalVariable(name: "n", arg: 2, scope: !51, file: !1, line: 15, type: !13)
!55 = !DILocalVariable(name: "swapped", scope: !51, file: !1, line: 17, type: !13)
!56 = !DILocalVariable(name: "i", scope: !57, file: !1, line: 20, type: !13)
!57 = distinct !DILexicalBlock(scope: !58, file: !1, line: 20, column: 9)
!58 = distinct !DILexicalBlock(scope: !51, file: !1, line: 18, column: 21)
!59 = !DILocalVariable(name: "t", scope: !60, file: !1, line: 22, type: !13)
!60 = distinct !DILexicalBlock(scope: !61, file: !1, line: 21, column: 34)
!61 = distinct !DILexicalBlock(scope: !62, file: !1, line: 21, column: 17)
!62 = distinct !DILexicalBlock(scope: !57, file: !1, line: 20, column: 9)
!63 = !DILocation(line: 0, scope: !51)
!64 = !DILocation(line: 18, column: 5, scope: !51)
!65 = !DILocation(line: 0, scope: !58)
!66 = distinct !{!66, !64, !67, !44, !45}
!67 = !DILocation(line: 27, column: 5, scope: !51)
!68 = !DILocation(line: 0, scope: !57)
!69 = !DILocation(line: 20, column: 9, scope: !57)
!70 = !DILocation(line: 21, column: 17, scope: !61)
!71 = !DILocation(line: 21, column: 24, scope: !61)
!72 = !DILocation(line: 21, column: 22, scope: !61)
!73 = !DILocation(line: 21, column: 17, scope: !62)
!74 = !DILocation(line: 0, scope: !60)
!75 = !DILocation(line: 23, column: 22, scope: !60)
!76 = !DILocation(line: 24, column: 26, scope: !60)
!77 = !DILocation(line: 26, column: 13, scope: !60)
!78 = !DILocation(line: 20, column: 27, scope: !62)
!79 = !DILocation(line: 20, column: 31, scope: !62)
!80 = distinct !{!80, !69, !81, !44, !45}
!81 = !DILocation(line: 26, column: 13, scope: !57)
!82 = !DILocation(line: 28, column: 1, scope: !51)
!83 = distinct !DISubprogram(name: "binary_search", scope: !1, file: !1, line: 31, type: !84, scopeLine: 32, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !88)
!84 = !DISubroutineType(types: !85)
!85 = !{!13, !86, !13, !13}
!86 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !87, size: 64)
!87 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !13)
!88 = !{!89, !90, !91, !92, !93, !94}
!89 = !DILocalVariable(name: "a", arg: 1, scope: !83, file: !1, line: 31, type: !86)
!90 = !DILocalVariable(name: "n", arg: 2, scope: !83, file: !1, line: 31, type: !13)
!91 = !DILocalVariable(name: "key", arg: 3, scope: !83, file: !1, line: 31, type: !13)
!92 = !DILocalVariable(name: "low", scope: !83, file: !1, line: 33, type: !13)
!93 = !DILocalVariable(name: "high", scope: !83, file: !1, line: 33, type: !13)
!94 = !DILocalVariable(name: "middle", scope: !95, file: !1, line: 35, type: !13)
!95 = distinct !DILexicalBlock(scope: !83, file: !1, line: 34, column: 25)
!96 = !DILocation(line: 0, scope: !83)
!97 = !DILocation(line: 33, column: 27, scope: !83)
!98 = !DILocation(line: 34, column: 5, scope: !83)
!99 = !DILocation(line: 33, column: 9, scope: !83)
!100 = !DILocation(line: 33, column: 18, scope: !83)
!101 = !DILocation(line: 34, column: 16, scope: !83)
!102 = !DILocation(line: 35, column: 34, scope: !95)
!103 = !DILocation(line: 35, column: 41, scope: !95)
!104 = !DILocation(line: 35, column: 26, scope: !95)
!105 = !DILocation(line: 0, scope: !95)
!106 = !DILocation(line: 36, column: 13, scope: !107)
!107 = distinct !DILexicalBlock(scope: !95, file: !1, line: 36, column: 13)
!108 = !DILocation(line: 36, column: 23, scope: !107)
!109 = !DILocation(line: 36, column: 13, scope: !95)
!110 = !DILocation(line: 38, column: 23, scope: !111)
!111 = distinct !DILexicalBlock(scope: !95, file: !1, line: 38, column: 13)
!112 = !DILocation(line: 38, column: 13, scope: !95)
!113 = !DILocation(line: 42, column: 5, scope: !83)
!114 = distinct !{!114, !98, !113, !44, !45}
!115 = !DILocation(line: 44, column: 1, scope: !83)
!116 = distinct !DISubprogram(name: "partition", scope: !1, file: !1, line: 47, type: !117, scopeLine: 48, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !119)
!117 = !DISubroutineType(types: !118)
!118 = !{!13, !12, !13}
!119 = !{!120, !121, !122, !123, !124, !126}
!120 = !DILocalVariable(name: "a", arg: 1, scope: !116, file: !1, line: 47, type: !12)
!121 = !DILocalVariable(name: "n", arg: 2, scope: !116, file: !1, line: 47, type: !13)
!122 = !DILocalVariable(name: "pivot", scope: !116, file: !1, line: 49, type: !13)
!123 = !DILocalVariable(name: "i", scope: !116, file: !1, line: 49, type: !13)
!124 = !DILocalVariable(name: "j", scope: !125, file: !1, line: 50, type: !13)
!125 = distinct !DILexicalBlock(scope: !116, file: !1, line: 50, column: 5)
!126 = !DILocalVariable(name: "t", scope: !127, file: !1, line: 52, type: !13)
!127 = distinct !DILexicalBlock(scope: !128, file: !1, line: 51, column: 27)
!128 = distinct !DILexicalBlock(scope: !129, file: !1, line: 51, column: 13)
!129 = distinct !DILexicalBlock(scope: !125, file: !1, line: 50, column: 5)
!130 = !DILocation(line: 0, scope: !116)
!131 = !DILocation(line: 49, column: 21, scope: !116)
!132 = !DILocation(line: 49, column: 17, scope: !116)
!133 = !DILocation(line: 0, scope: !125)
!134 = !DILocation(line: 50, column: 23, scope: !129)
!135 = !DILocation(line: 50, column: 5, scope: !125)
!136 = !DILocation(line: 57, column: 16, scope: !116)
!137 = !DILocation(line: 57, column: 14, scope: !116)
!138 = !DILocation(line: 58, column: 10, scope: !116)
!139 = !DILocation(line: 59, column: 5, scope: !116)
!140 = !DILocation(line: 51, column: 13, scope: !128)
!141 = !DILocation(line: 51, column: 18, scope: !128)
!142 = !DILocation(line: 51, column: 13, scope: !129)
!143 = !DILocation(line: 52, column: 21, scope: !127)
!144 = !DILocation(line: 0, scope: !127)
!145 = !DILocation(line: 53, column: 18, scope: !127)
!146 = !DILocation(line: 54, column: 18, scope: !127)
!147 = !DILocation(line: 55, column: 14, scope: !127)
!148 = !DILocation(line: 56, column: 9, scope: !127)
!149 = !DILocation(line: 50, column: 33, scope: !129)
!150 = distinct !{!150, !135, !151, !44, !45}
!151 = !DILocation(line: 56, column: 9, scope: !125)
!152 = distinct !DISubprogram(name: "find", scope: !1, file: !1, line: 63, type: !153, scopeLine: 64, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !155)
!153 = !DISubroutineType(types: !154)
!154 = !{!13, !86, !13, !86, !13}
!155 = !{!156, !157, !158, !159, !160, !162}
!156 = !DILocalVariable(name: "text", arg: 1, scope: !152, file: !1, line: 63, type: !86)
!157 = !DILocalVariable(name: "n", arg: 2, scope: !152, file: !1, line: 63, type: !13)
!158 = !DILocalVariable(name: "pattern", arg: 3, scope: !152, file: !1, line: 63, type: !86)
!159 = !DILocalVariable(name: "m", arg: 4, scope: !152, file: !1, line: 63, type: !13)
!160 = !DILocalVariable(name: "i", scope: !161, file: !1, line: 65, type: !13)
!161 = distinct !DILexicalBlock(scope: !152, file: !1, line: 65, column: 5)
!162 = !DILocalVariable(name: "j", scope: !163, file: !1, line: 66, type: !13)
!163 = distinct !DILexicalBlock(scope: !164, file: !1, line: 65, column: 38)
!164 = distinct !DILexicalBlock(scope: !161, file: !1, line: 65, column: 5)
!165 = !DILocation(line: 0, scope: !152)
!166 = !DILocation(line: 0, scope: !161)
!167 = !DILocation(line: 65, column: 27, scope: !164)
!168 = !DILocation(line: 65, column: 5, scope: !161)
!169 = !DILocation(line: 65, column: 34, scope: !164)
!170 = !DILocation(line: 65, column: 23, scope: !164)
!171 = distinct !{!171, !168, !172, !44, !45}
!172 = !DILocation(line: 71, column: 5, scope: !161)
!173 = !DILocation(line: 0, scope: !163)
!174 = !DILocation(line: 67, column: 22, scope: !163)
!175 = !DILocation(line: 67, column: 32, scope: !163)
!176 = !DILocation(line: 67, column: 25, scope: !163)
!177 = !DILocation(line: 67, column: 40, scope: !163)
!178 = !DILocation(line: 67, column: 37, scope: !163)
!179 = !DILocation(line: 67, column: 9, scope: !163)
!180 = !DILocation(line: 68, column: 14, scope: !163)
!181 = !DILocation(line: 67, column: 18, scope: !163)
!182 = distinct !{!182, !179, !180, !44, !45}
!183 = !DILocation(line: 69, column: 15, scope: !184)
!184 = distinct !DILexicalBlock(scope: !163, file: !1, line: 69, column: 13)
!185 = !DILocation(line: 0, scope: !164)
!186 = !DILocation(line: 73, column: 1, scope: !152)
!187 = distinct !DISubprogram(name: "floyd_warshall", scope: !1, file: !1, line: 75, type: !188, scopeLine: 76, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !194)
!188 = !DISubroutineType(types: !189)
!189 = !{null, !13, !190}
!190 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !191, size: 64)
!191 = !DICompositeType(tag: DW_TAG_array_type, baseType: !13, elements: !192)
!192 = !{!193}
!193 = !DISubrange(count: -1)
!194 = !{!195, !196, !197, !199, !202}
!195 = !DILocalVariable(name: "n", arg: 1, scope: !187, file: !1, line: 75, type: !13)
!196 = !DILocalVariable(name: "path", arg: 2, scope: !187, file: !1, line: 75, type: !190)
!197 = !DILocalVariable(name: "k", scope: !198, file: !1, line: 77, type: !13)
!198 = distinct !DILexicalBlock(scope: !187, file: !1, line: 77, column: 5)
!199 = !DILocalVariable(name: "i", scope: !200, file: !1, line: 78, type: !13)
!200 = distinct !DILexicalBlock(scope: !201, file: !1, line: 78, column: 9)
!201 = distinct !DILexicalBlock(scope: !198, file: !1, line: 77, column: 5)
!202 = !DILocalVariable(name: "j", scope: !203, file: !1, line: 79, type: !13)
!203 = distinct !DILexicalBlock(scope: !204, file: !1, line: 79, column: 13)
!204 = distinct !DILexicalBlock(scope: !200, file: !1, line: 78, column: 9)
!205 = !DILocation(line: 0, scope: !187)
!206 = !DILocation(line: 0, scope: !198)
!207 = !DILocation(line: 77, column: 23, scope: !201)
!208 = !DILocation(line: 77, column: 5, scope: !198)
!209 = !DILocation(line: 0, scope: !200)
!210 = !DILocation(line: 78, column: 9, scope: !200)
!211 = !DILocation(line: 82, column: 1, scope: !187)
!212 = !DILocation(line: 0, scope: !203)
!213 = !DILocation(line: 79, column: 13, scope: !203)
!214 = !DILocation(line: 77, column: 29, scope: !201)
!215 = distinct !{!215, !208, !216, !44, !45}
!216 = !DILocation(line: 81, column: 56, scope: !198)
!217 = !DILocation(line: 78, column: 33, scope: !204)
!218 = !DILocation(line: 78, column: 27, scope: !204)
!219 = distinct !{!219, !210, !220, !44, !45}
!220 = !DILocation(line: 81, column: 56, scope: !200)
!221 = !DILocation(line: 80, column: 21, scope: !222)
!222 = distinct !DILexicalBlock(scope: !223, file: !1, line: 80, column: 21)
!223 = distinct !DILexicalBlock(scope: !203, file: !1, line: 79, column: 13)
!224 = !DILocation(line: 80, column: 34, scope: !222)
!225 = !DILocation(line: 80, column: 32, scope: !222)
!226 = !DILocation(line: 80, column: 47, scope: !222)
!227 = !DILocation(line: 80, column: 45, scope: !222)
!228 = !DILocation(line: 80, column: 21, scope: !223)
!229 = !DILocation(line: 81, column: 32, scope: !222)
!230 = !DILocation(line: 81, column: 21, scope: !222)
!231 = !DILocation(line: 79, column: 37, scope: !223)
!232 = !DILocation(line: 79, column: 31, scope: !223)
!233 = distinct !{!233, !213, !234, !44, !45}
!234 = !DILocation(line: 81, column: 56, scope: !203)
!235 = distinct !DISubprogram(name: "count_ends", scope: !1, file: !1, line: 85, type: !236, scopeLine: 86, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !238)
!236 = !DISubroutineType(types: !237)
!237 = !{null, !86, !13, !12}
!238 = !{!239, !240, !241, !242}
!239 = !DILocalVariable(name: "text", arg: 1, scope: !235, file: !1, line: 85, type: !86)
!240 = !DILocalVariable(name: "n", arg: 2, scope: !235, file: !1, line: 85, type: !13)
!241 = !DILocalVariable(name: "counts", arg: 3, scope: !235, file: !1, line: 85, type: !12)
!242 = !DILocalVariable(name: "i", scope: !243, file: !1, line: 87, type: !13)
!243 = distinct !DILexicalBlock(scope: !235, file: !1, line: 87, column: 5)
!244 = !DILocation(line: 0, scope: !235)
!245 = !DILocation(line: 0, scope: !243)
!246 = !DILocation(line: 87, column: 23, scope: !247)
!247 = distinct !DILexicalBlock(scope: !243, file: !1, line: 87, column: 5)
!248 = !DILocation(line: 87, column: 5, scope: !243)
!249 = !DILocation(line: 105, column: 1, scope: !235)
!250 = !DILocation(line: 88, column: 20, scope: !251)
!251 = distinct !DILexicalBlock(scope: !252, file: !1, line: 88, column: 13)
!252 = distinct !DILexicalBlock(scope: !247, file: !1, line: 87, column: 33)
!253 = !DILocation(line: 88, column: 13, scope: !251)
!254 = !DILocation(line: 88, column: 25, scope: !251)
!255 = !DILocation(line: 88, column: 13, scope: !252)
!256 = !DILocation(line: 90, column: 17, scope: !252)
!257 = !DILocation(line: 90, column: 9, scope: !252)
!258 = !DILocation(line: 96, column: 13, scope: !259)
!259 = distinct !DILexicalBlock(scope: !252, file: !1, line: 90, column: 26)
!260 = !DILocation(line: 99, column: 13, scope: !259)
!261 = !DILocation(line: 101, column: 25, scope: !262)
!262 = distinct !DILexicalBlock(scope: !259, file: !1, line: 101, column: 17)
!263 = !DILocation(line: 101, column: 17, scope: !259)
!264 = !DILocation(line: 0, scope: !259)
!265 = !DILocation(line: 87, column: 29, scope: !247)
!266 = distinct !{!266, !248, !267, !44, !45}
!267 = !DILocation(line: 104, column: 5, scope: !243)
