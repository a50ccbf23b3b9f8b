; ModuleID = 'linear_algebra.c'
source_filename = "linear_algebra.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @gemm(i32 noundef %0, i32 noundef %1, i32 noundef %2, float noundef %3, float noundef %4, ptr noalias nocapture noundef %5, ptr noalias nocapture noundef readonly %6, ptr noalias nocapture noundef readonly %7) local_unnamed_addr #0 !dbg !9 {
  call void @llvm.dbg.value(metadata i32 %0, metadata !20, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata i32 %1, metadata !21, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata i32 %2, metadata !22, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata float %3, metadata !23, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata float %4, metadata !24, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata ptr %5, metadata !25, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata ptr %6, metadata !26, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata ptr %7, metadata !27, metadata !DIExpression()), !dbg !39
  call void @llvm.dbg.value(metadata i32 0, metadata !28, metadata !DIExpression()), !dbg !40
  %9 = icmp sgt i32 %0, 0, !dbg !41
  br i1 %9, label %10, label %26, !dbg !42

10:                                               ; preds = %8
  %11 = icmp sgt i32 %1, 0
  %12 = icmp sgt i32 %2, 0
  %13 = icmp sgt i32 %1, 0
  %14 = sext i32 %1 to i64, !dbg !42
  %15 = sext i32 %1 to i64, !dbg !42
  %16 = sext i32 %2 to i64, !dbg !42
  %17 = sext i32 %1 to i64, !dbg !42
  %18 = zext i32 %0 to i64, !dbg !41
  %19 = zext i32 %1 to i64
  %20 = zext i32 %2 to i64
  %21 = zext i32 %1 to i64
  br label %22, !dbg !42

22:                                               ; preds = %10, %47
  %23 = phi i64 [ 0, %10 ], [ %48, %47 ]
  call void @llvm.dbg.value(metadata i64 %23, metadata !28, metadata !DIExpression()), !dbg !40
  call void @llvm.dbg.value(metadata i32 0, metadata !30, metadata !DIExpression()), !dbg !43
  br i1 %11, label %24, label %27, !dbg !44

24:                                               ; preds = %22
  %25 = mul nsw i64 %23, %15
  br label %31, !dbg !44

26:                                               ; preds = %47, %8
  ret void, !dbg !45

27:                                               ; preds = %31, %22
  call void @llvm.dbg.value(metadata i32 0, metadata !34, metadata !DIExpression()), !dbg !46
  br i1 %12, label %28, label %47, !dbg !47

28:                                               ; preds = %27
  %29 = mul nsw i64 %23, %16
  %30 = mul nsw i64 %23, %17
  br label %39, !dbg !47

31:                                               ; preds = %24, %31
  %32 = phi i64 [ 0, %24 ], [ %37, %31 ]
  call void @llvm.dbg.value(metadata i64 %32, metadata !30, metadata !DIExpression()), !dbg !43
  %33 = add nsw i64 %32, %25, !dbg !48
  %34 = getelementptr inbounds float, ptr %5, i64 %33, !dbg !50
  %35 = load float, ptr %34, align 4, !dbg !51, !tbaa !52
  %36 = fmul float %35, %4, !dbg !51
  store float %36, ptr %34, align 4, !dbg !51, !tbaa !52
  %37 = add nuw nsw i64 %32, 1, !dbg !56
  call void @llvm.dbg.value(metadata i64 %37, metadata !30, metadata !DIExpression()), !dbg !43
  %38 = icmp eq i64 %37, %19, !dbg !57
  br i1 %38, label %27, label %31, !dbg !44, !llvm.loop !58

39:                                               ; preds = %28, %50
  %40 = phi i64 [ 0, %28 ], [ %51, %50 ]
  call void @llvm.dbg.value(metadata i64 %40, metadata !34, metadata !DIExpression()), !dbg !46
  call void @llvm.dbg.value(metadata i32 0, metadata !36, metadata !DIExpression()), !dbg !62
  br i1 %13, label %41, label %50, !dbg !63

41:                                               ; preds = %39
  %42 = add nsw i64 %40, %29
  %43 = getelementptr inbounds float, ptr %6, i64 %42
  %44 = load float, ptr %43, align 4, !tbaa !52
  %45 = fmul float %44, %3
  %46 = mul nsw i64 %40, %14
  br label %53, !dbg !63

47:                                               ; preds = %50, %27
  %48 = add nuw nsw i64 %23, 1, !dbg !64
  call void @llvm.dbg.value(metadata i64 %48, metadata !28, metadata !DIExpression()), !dbg !40
  %49 = icmp eq i64 %48, %18, !dbg !41
  br i1 %49, label %26, label %22, !dbg !42, !llvm.loop !65

50:                                               ; preds = %53, %39
  %51 = add nuw nsw i64 %40, 1, !dbg !67
  call void @llvm.dbg.value(metadata i64 %51, metadata !34, metadata !DIExpression()), !dbg !46
  %52 = icmp eq i64 %51, %20, !dbg !68
  br i1 %52, label %47, label %39, !dbg !47, !llvm.loop !69

53:                                               ; preds = %41, %53
  %54 = phi i64 [ 0, %41 ], [ %62, %53 ]
  call void @llvm.dbg.value(metadata i64 %54, metadata !36, metadata !DIExpression()), !dbg !62
  %55 = add nsw i64 %54, %46, !dbg !71
  %56 = getelementptr inbounds float, ptr %7, i64 %55, !dbg !73
  %57 = load float, ptr %56, align 4, !dbg !73, !tbaa !52
  %58 = add nsw i64 %54, %30, !dbg !74
  %59 = getelementptr inbounds float, ptr %5, i64 %58, !dbg !75
  %60 = load float, ptr %59, align 4, !dbg !76, !tbaa !52
  %61 = tail call float @llvm.fmuladd.f32(float %45, float %57, float %60), !dbg !76
  store float %61, ptr %59, align 4, !dbg !76, !tbaa !52
  %62 = add nuw nsw i64 %54, 1, !dbg !77
  call void @llvm.dbg.value(metadata i64 %62, metadata !36, metadata !DIExpression()), !dbg !62
  %63 = icmp eq i64 %62, %21, !dbg !78
  br i1 %63, label %50, label %53, !dbg !63, !llvm.loop !79
}

; Function Attrs: mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare float @llvm.fmuladd.f32(float, float, float) #1

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @atax(i32 noundef %0, i32 noundef %1, ptr nocapture noundef readonly %2, ptr nocapture noundef readonly %3, ptr nocapture noundef %4, ptr nocapture noundef %5) local_unnamed_addr #0 !dbg !81 {
  call void @llvm.dbg.value(metadata i32 %0, metadata !89, metadata !DIExpression()), !dbg !105
  call void @llvm.dbg.value(metadata i32 %1, metadata !90, metadata !DIExpression()), !dbg !105
  call void @llvm.dbg.value(metadata ptr %2, metadata !91, metadata !DIExpression()), !dbg !105
  call void @llvm.dbg.value(metadata ptr %3, metadata !92, metadata !DIExpression()), !dbg !105
  call void @llvm.dbg.value(metadata ptr %4, metadata !93, metadata !DIExpression()), !dbg !105
  call void @llvm.dbg.value(metadata ptr %5, metadata !94, metadata !DIExpression()), !dbg !105
  %7 = zext i32 %1 to i64
  call void @llvm.dbg.value(metadata i32 0, metadata !95, metadata !DIExpression()), !dbg !106
  %8 = icmp sgt i32 %1, 0, !dbg !107
  br i1 %8, label %9, label %12, !dbg !109

9:                                                ; preds = %6
  %10 = zext i32 %1 to i64, !dbg !109
  %11 = shl nuw nsw i64 %10, 2, !dbg !109
  tail call void @llvm.memset.p0.i64(ptr align 4 %4, i8 0, i64 %11, i1 false), !dbg !110, !tbaa !52
  call void @llvm.dbg.value(metadata i64 poison, metadata !95, metadata !DIExpression()), !dbg !106
  br label %12, !dbg !111

12:                                               ; preds = %9, %6
  call void @llvm.dbg.value(metadata i32 0, metadata !97, metadata !DIExpression()), !dbg !112
  %13 = icmp sgt i32 %0, 0, !dbg !111
  br i1 %13, label %14, label %20, !dbg !113

14:                                               ; preds = %12
  %15 = icmp sgt i32 %1, 0
  %16 = icmp sgt i32 %1, 0
  %17 = zext i32 %0 to i64, !dbg !111
  %18 = zext i32 %1 to i64
  %19 = zext i32 %1 to i64
  br label %21, !dbg !113

20:                                               ; preds = %42, %12
  ret void, !dbg !114

21:                                               ; preds = %14, %42
  %22 = phi i64 [ 0, %14 ], [ %43, %42 ]
  call void @llvm.dbg.value(metadata i64 %22, metadata !97, metadata !DIExpression()), !dbg !112
  %23 = getelementptr inbounds float, ptr %5, i64 %22, !dbg !115
  store float 0.000000e+00, ptr %23, align 4, !dbg !116, !tbaa !52
  call void @llvm.dbg.value(metadata i32 0, metadata !99, metadata !DIExpression()), !dbg !117
  br i1 %15, label %24, label %28, !dbg !118

24:                                               ; preds = %21
  %25 = mul nuw nsw i64 %22, %7
  %26 = getelementptr inbounds float, ptr %2, i64 %25
  %27 = load float, ptr %23, align 4, !tbaa !52
  br label %32, !dbg !118

28:                                               ; preds = %32, %21
  call void @llvm.dbg.value(metadata i32 0, metadata !103, metadata !DIExpression()), !dbg !119
  br i1 %16, label %29, label %42, !dbg !120

29:                                               ; preds = %28
  %30 = mul nuw nsw i64 %22, %7
  %31 = getelementptr inbounds float, ptr %2, i64 %30
  br label %45, !dbg !120

32:                                               ; preds = %24, %32
  %33 = phi i64 [ 0, %24 ], [ %40, %32 ], !dbg !117
  %34 = phi float [ %27, %24 ], [ %39, %32 ], !dbg !117
  call void @llvm.dbg.value(metadata i64 %33, metadata !99, metadata !DIExpression()), !dbg !117
  %35 = getelementptr inbounds float, ptr %26, i64 %33, !dbg !121
  %36 = load float, ptr %35, align 4, !dbg !121, !tbaa !52
  %37 = getelementptr inbounds float, ptr %3, i64 %33, !dbg !123
  %38 = load float, ptr %37, align 4, !dbg !123, !tbaa !52
  %39 = tail call float @llvm.fmuladd.f32(float %36, float %38, float %34), !dbg !124
  store float %39, ptr %23, align 4, !dbg !124, !tbaa !52
  %40 = add nuw nsw i64 %33, 1, !dbg !125
  call void @llvm.dbg.value(metadata i64 %40, metadata !99, metadata !DIExpression()), !dbg !117
  %41 = icmp eq i64 %40, %18, !dbg !126
  br i1 %41, label %28, label %32, !dbg !118, !llvm.loop !127

42:                                               ; preds = %45, %28
  %43 = add nuw nsw i64 %22, 1, !dbg !129
  call void @llvm.dbg.value(metadata i64 %43, metadata !97, metadata !DIExpression()), !dbg !112
  %44 = icmp eq i64 %43, %17, !dbg !111
  br i1 %44, label %20, label %21, !dbg !113, !llvm.loop !130

45:                                               ; preds = %29, %45
  %46 = phi i64 [ 0, %29 ], [ %53, %45 ]
  call void @llvm.dbg.value(metadata i64 %46, metadata !103, metadata !DIExpression()), !dbg !119
  %47 = getelementptr inbounds float, ptr %31, i64 %46, !dbg !132
  %48 = load float, ptr %47, align 4, !dbg !132, !tbaa !52
  %49 = load float, ptr %23, align 4, !dbg !134, !tbaa !52
  %50 = getelementptr inbounds float, ptr %4, i64 %46, !dbg !135
  %51 = load float, ptr %50, align 4, !dbg !136, !tbaa !52
  %52 = tail call float @llvm.fmuladd.f32(float %48, float %49, float %51), !dbg !136
  store float %52, ptr %50, align 4, !dbg !136, !tbaa !52
  %53 = add nuw nsw i64 %46, 1, !dbg !137
  call void @llvm.dbg.value(metadata i64 %53, metadata !103, metadata !DIExpression()), !dbg !119
  %54 = icmp eq i64 %53, %19, !dbg !138
  br i1 %54, label %42, label %45, !dbg !120, !llvm.loop !139
}

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @mvt(i32 noundef %0, ptr nocapture noundef %1, ptr nocapture noundef %2, ptr nocapture noundef readonly %3, ptr nocapture noundef readonly %4, ptr nocapture noundef readonly %5) local_unnamed_addr #0 !dbg !141 {
  call void @llvm.dbg.value(metadata i32 %0, metadata !145, metadata !DIExpression()), !dbg !161
  call void @llvm.dbg.value(metadata ptr %1, metadata !146, metadata !DIExpression()), !dbg !161
  call void @llvm.dbg.value(metadata ptr %2, metadata !147, metadata !DIExpression()), !dbg !161
  call void @llvm.dbg.value(metadata ptr %3, metadata !148, metadata !DIExpression()), !dbg !161
  call void @llvm.dbg.value(metadata ptr %4, metadata !149, metadata !DIExpression()), !dbg !161
  call void @llvm.dbg.value(metadata ptr %5, metadata !150, metadata !DIExpression()), !dbg !161
  %7 = zext i32 %0 to i64
  call void @llvm.dbg.value(metadata i32 0, metadata !151, metadata !DIExpression()), !dbg !162
  %8 = icmp sgt i32 %0, 0, !dbg !163
  br i1 %8, label %9, label %18, !dbg !164

9:                                                ; preds = %6
  %10 = zext i32 %0 to i64, !dbg !163
  %11 = zext i32 %0 to i64
  br label %12, !dbg !164

12:                                               ; preds = %9, %23
  %13 = phi i64 [ 0, %9 ], [ %24, %23 ]
  call void @llvm.dbg.value(metadata i64 %13, metadata !151, metadata !DIExpression()), !dbg !162
  call void @llvm.dbg.value(metadata i32 0, metadata !153, metadata !DIExpression()), !dbg !165
  %14 = getelementptr inbounds float, ptr %1, i64 %13
  %15 = mul nuw nsw i64 %13, %7
  %16 = getelementptr inbounds float, ptr %5, i64 %15
  %17 = load float, ptr %14, align 4, !tbaa !52
  br label %26, !dbg !166

18:                                               ; preds = %23, %6
  call void @llvm.dbg.value(metadata i32 0, metadata !156, metadata !DIExpression()), !dbg !167
  %19 = icmp sgt i32 %0, 0, !dbg !168
  br i1 %19, label %20, label %41, !dbg !169

20:                                               ; preds = %18
  %21 = zext i32 %0 to i64, !dbg !168
  %22 = zext i32 %0 to i64
  br label %36, !dbg !169

23:                                               ; preds = %26
  %24 = add nuw nsw i64 %13, 1, !dbg !170
  call void @llvm.dbg.value(metadata i64 %24, metadata !151, metadata !DIExpression()), !dbg !162
  %25 = icmp eq i64 %24, %10, !dbg !163
  br i1 %25, label %18, label %12, !dbg !164, !llvm.loop !171

26:                                               ; preds = %12, %26
  %27 = phi i64 [ 0, %12 ], [ %34, %26 ], !dbg !165
  %28 = phi float [ %17, %12 ], [ %33, %26 ], !dbg !165
  call void @llvm.dbg.value(metadata i64 %27, metadata !153, metadata !DIExpression()), !dbg !165
  %29 = getelementptr inbounds float, ptr %16, i64 %27, !dbg !173
  %30 = load float, ptr %29, align 4, !dbg !173, !tbaa !52
  %31 = getelementptr inbounds float, ptr %3, i64 %27, !dbg !175
  %32 = load float, ptr %31, align 4, !dbg !175, !tbaa !52
  %33 = tail call float @llvm.fmuladd.f32(float %30, float %32, float %28), !dbg !176
  store float %33, ptr %14, align 4, !dbg !177, !tbaa !52
  %34 = add nuw nsw i64 %27, 1, !dbg !178
  call void @llvm.dbg.value(metadata i64 %34, metadata !153, metadata !DIExpression()), !dbg !165
  %35 = icmp eq i64 %34, %11, !dbg !179
  br i1 %35, label %23, label %26, !dbg !166, !llvm.loop !180

36:                                               ; preds = %20, %42
  %37 = phi i64 [ 0, %20 ], [ %43, %42 ]
  call void @llvm.dbg.value(metadata i64 %37, metadata !156, metadata !DIExpression()), !dbg !167
  call void @llvm.dbg.value(metadata i32 0, metadata !158, metadata !DIExpression()), !dbg !182
  %38 = getelementptr inbounds float, ptr %2, i64 %37
  %39 = load float, ptr %38, align 4, !tbaa !52
  %40 = getelementptr inbounds float, ptr %5, i64 %37
  br label %45, !dbg !183

41:                                               ; preds = %42, %18
  ret void, !dbg !184

42:                                               ; preds = %45
  %43 = add nuw nsw i64 %37, 1, !dbg !185
  call void @llvm.dbg.value(metadata i64 %43, metadata !156, metadata !DIExpression()), !dbg !167
  %44 = icmp eq i64 %43, %21, !dbg !168
  br i1 %44, label %41, label %36, !dbg !169, !llvm.loop !186

45:                                               ; preds = %36, %45
  %46 = phi i64 [ 0, %36 ], [ %54, %45 ], !dbg !182
  %47 = phi float [ %39, %36 ], [ %53, %45 ], !dbg !182
  call void @llvm.dbg.value(metadata i64 %46, metadata !158, metadata !DIExpression()), !dbg !182
  %48 = mul nuw nsw i64 %46, %7, !dbg !188
  %49 = getelementptr inbounds float, ptr %40, i64 %48, !dbg !188
  %50 = load float, ptr %49, align 4, !dbg !188, !tbaa !52
  %51 = getelementptr inbounds float, ptr %4, i64 %46, !dbg !190
  %52 = load float, ptr %51, align 4, !dbg !190, !tbaa !52
  %53 = tail call float @llvm.fmuladd.f32(float %50, float %52, float %47), !dbg !191
  store float %53, ptr %38, align 4, !dbg !192, !tbaa !52
  %54 = add nuw nsw i64 %46, 1, !dbg !193
  call void @llvm.dbg.value(metadata i64 %54, metadata !158, metadata !DIExpression()), !dbg !182
  %55 = icmp eq i64 %54, %22, !dbg !194
  br i1 %55, label %42, label %45, !dbg !183, !llvm.loop !195
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @transpose(ptr nocapture noundef %0, i32 noundef %1) local_unnamed_addr #2 !dbg !197 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !202, metadata !DIExpression()), !dbg !212
  call void @llvm.dbg.value(metadata i32 %1, metadata !203, metadata !DIExpression()), !dbg !212
  call void @llvm.dbg.value(metadata i32 0, metadata !204, metadata !DIExpression()), !dbg !213
  %3 = icmp sgt i32 %1, 0, !dbg !214
  br i1 %3, label %4, label %13, !dbg !215

4:                                                ; preds = %2
  %5 = sext i32 %1 to i64, !dbg !215
  %6 = sext i32 %1 to i64, !dbg !215
  %7 = sext i32 %1 to i64, !dbg !215
  %8 = zext i32 %1 to i64, !dbg !214
  %9 = zext i32 %1 to i64
  br label %14, !dbg !215

10:                                               ; preds = %21, %14
  call void @llvm.dbg.value(metadata i64 %17, metadata !204, metadata !DIExpression()), !dbg !213
  %11 = add nuw nsw i64 %16, 1, !dbg !215
  %12 = icmp eq i64 %17, %8, !dbg !214
  br i1 %12, label %13, label %14, !dbg !215, !llvm.loop !216

13:                                               ; preds = %10, %2
  ret void, !dbg !218

14:                                               ; preds = %4, %10
  %15 = phi i64 [ 0, %4 ], [ %17, %10 ]
  %16 = phi i64 [ 1, %4 ], [ %11, %10 ]
  call void @llvm.dbg.value(metadata i64 %15, metadata !204, metadata !DIExpression()), !dbg !213
  %17 = add nuw nsw i64 %15, 1, !dbg !219
  call void @llvm.dbg.value(metadata i64 %17, metadata !206, metadata !DIExpression()), !dbg !220
  %18 = icmp slt i64 %17, %6, !dbg !221
  br i1 %18, label %19, label %10, !dbg !222

19:                                               ; preds = %14
  %20 = mul nsw i64 %15, %7
  br label %21, !dbg !222

21:                                               ; preds = %19, %21
  %22 = phi i64 [ %16, %19 ], [ %30, %21 ]
  call void @llvm.dbg.value(metadata i64 %22, metadata !206, metadata !DIExpression()), !dbg !220
  %23 = add nsw i64 %22, %20, !dbg !223
  %24 = getelementptr inbounds i32, ptr %0, i64 %23, !dbg !224
  %25 = load i32, ptr %24, align 4, !dbg !224, !tbaa !225
  call void @llvm.dbg.value(metadata i32 %25, metadata !209, metadata !DIExpression()), !dbg !227
  %26 = mul nsw i64 %22, %5, !dbg !228
  %27 = add nsw i64 %26, %15, !dbg !229
  %28 = getelementptr inbounds i32, ptr %0, i64 %27, !dbg !230
  %29 = load i32, ptr %28, align 4, !dbg !230, !tbaa !225
  store i32 %29, ptr %24, align 4, !dbg !231, !tbaa !225
  store i32 %25, ptr %28, align 4, !dbg !232, !tbaa !225
  %30 = add nuw nsw i64 %22, 1, !dbg !233
  call void @llvm.dbg.value(metadata i64 %30, metadata !206, metadata !DIExpression()), !dbg !220
  %31 = icmp eq i64 %30, %9, !dbg !221
  br i1 %31, label %10, label %21, !dbg !222, !llvm.loop !234
}

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @trisolv(i32 noundef %0, ptr nocapture noundef readonly %1, ptr nocapture noundef %2, ptr nocapture noundef readonly %3) local_unnamed_addr #0 !dbg !236 {
  call void @llvm.dbg.value(metadata i32 %0, metadata !240, metadata !DIExpression()), !dbg !251
  call void @llvm.dbg.value(metadata ptr %1, metadata !241, metadata !DIExpression()), !dbg !251
  call void @llvm.dbg.value(metadata ptr %2, metadata !242, metadata !DIExpression()), !dbg !251
  call void @llvm.dbg.value(metadata ptr %3, metadata !243, metadata !DIExpression()), !dbg !251
  call void @llvm.dbg.value(metadata i32 0, metadata !244, metadata !DIExpression()), !dbg !252
  %5 = icmp sgt i32 %0, 0, !dbg !253
  br i1 %5, label %6, label %10, !dbg !254

6:                                                ; preds = %4
  %7 = add i32 %0, 1
  %8 = sext i32 %0 to i64, !dbg !254
  %9 = zext i32 %0 to i64, !dbg !253
  br label %11, !dbg !254

10:                                               ; preds = %18, %4
  ret void, !dbg !255

11:                                               ; preds = %6, %18
  %12 = phi i64 [ 0, %6 ], [ %27, %18 ]
  call void @llvm.dbg.value(metadata i64 %12, metadata !244, metadata !DIExpression()), !dbg !252
  %13 = getelementptr inbounds float, ptr %3, i64 %12, !dbg !256
  %14 = load float, ptr %13, align 4, !dbg !256, !tbaa !52
  call void @llvm.dbg.value(metadata float %14, metadata !246, metadata !DIExpression()), !dbg !257
  call void @llvm.dbg.value(metadata i32 0, metadata !249, metadata !DIExpression()), !dbg !258
  %15 = icmp eq i64 %12, 0, !dbg !259
  br i1 %15, label %18, label %16, !dbg !261

16:                                               ; preds = %11
  %17 = mul nsw i64 %12, %8
  br label %29, !dbg !261

18:                                               ; preds = %29, %11
  %19 = phi float [ %14, %11 ], [ %38, %29 ], !dbg !257
  %20 = trunc i64 %12 to i32, !dbg !262
  %21 = mul i32 %7, %20, !dbg !262
  %22 = sext i32 %21 to i64, !dbg !263
  %23 = getelementptr inbounds float, ptr %1, i64 %22, !dbg !263
  %24 = load float, ptr %23, align 4, !dbg !263, !tbaa !52
  %25 = fdiv float %19, %24, !dbg !264
  %26 = getelementptr inbounds float, ptr %2, i64 %12, !dbg !265
  store float %25, ptr %26, align 4, !dbg !266, !tbaa !52
  %27 = add nuw nsw i64 %12, 1, !dbg !267
  call void @llvm.dbg.value(metadata i64 %27, metadata !244, metadata !DIExpression()), !dbg !252
  %28 = icmp eq i64 %27, %9, !dbg !253
  br i1 %28, label %10, label %11, !dbg !254, !llvm.loop !268

29:                                               ; preds = %16, %29
  %30 = phi i64 [ 0, %16 ], [ %39, %29 ]
  %31 = phi float [ %14, %16 ], [ %38, %29 ]
  call void @llvm.dbg.value(metadata i64 %30, metadata !249, metadata !DIExpression()), !dbg !258
  call void @llvm.dbg.value(metadata float %31, metadata !246, metadata !DIExpression()), !dbg !257
  %32 = add nsw i64 %30, %17, !dbg !270
  %33 = getelementptr inbounds float, ptr %1, i64 %32, !dbg !271
  %34 = load float, ptr %33, align 4, !dbg !271, !tbaa !52
  %35 = getelementptr inbounds float, ptr %2, i64 %30, !dbg !272
  %36 = load float, ptr %35, align 4, !dbg !272, !tbaa !52
  %37 = fneg float %34, !dbg !273
  %38 = tail call float @llvm.fmuladd.f32(float %37, float %36, float %31), !dbg !273
  call void @llvm.dbg.value(metadata float %38, metadata !246, metadata !DIExpression()), !dbg !257
  %39 = add nuw nsw i64 %30, 1, !dbg !274
  call void @llvm.dbg.value(metadata i64 %39, metadata !249, metadata !DIExpression()), !dbg !258
  %40 = icmp eq i64 %39, %12, !dbg !259
  br i1 %40, label %18, label %29, !dbg !261, !llvm.loop !275
}

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare void @llvm.dbg.value(metadata, metadata, metadata) #3

; Function Attrs: nocallback nofree nounwind willreturn memory(argmem: write)
declare void @llvm.memset.p0.i64(ptr nocapture writeonly, i8, i64, i1 immarg) #4

attributes #0 = { nofree nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none) }
attributes #2 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #3 = { nocallback nofree nosync nounwind speculatable willreturn memory(none) }
attributes #4 = { nocallback nofree nounwind willreturn memory(argmem: write) }

!llvm.dbg.cu = !{!0}
!llvm.module.flags = !{!2, !3, !4, !5, !6, !7}
!llvm.ident = !{!8}

!0 = distinct !DICompileUnit(language: DW_LANG_C11, file: !1, producer: "Debian clang version 16.0.6 (15~deb12u1)", isOptimized: true, runtimeVersion: 0, emissionKind: FullDebug, splitDebugInlining: false, nameTableKind: None)
!1 = !DIFile(filename: "linear_algebra.c", directory: ".", checksumkind: CSK_MD5, checksum: "3f654c0ebb059dd9307cbd9d55b60289")
!2 = !{i32 7, !"Dwarf Version", i32 5}
!3 = !{i32 2, !"Debug Info Version", i32 3}
!4 = !{i32 1, !"wchar_size", i32 4}
!5 = !{i32 8, !"PIC Level", i32 2}
!6 = !{i32 7, !"PIE Level", i32 2}
!7 = !{i32 7, !"uwtable", i32 2}
!8 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!9 = distinct !DISubprogram(name: "gemm", scope: !1, file: !1, line: 3, type: !10, scopeLine: 5, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !19)
!10 = !DISubroutineType(types: !11)
!11 = !{null, !12, !12, !12, !13, !13, !14, !16, !16}
!12 = !DIBasicType(name: "int", size: 32, encoding: DW_ATE_signed)
!13 = !DIBasicType(name: "float", size: 32, encoding: DW_ATE_float)
!14 = !DIDerivedType(tag: DW_TAG_restrict_type, baseType: !15)
!15 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !13, size: 64)
!16 = !DIDerivedType(tag: DW_TAG_restrict_type, baseType: !17)
!17 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !18, size: 64)
!18 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !13)
!19 = !{!20, !21, !22, !23, !24, !25, !26, !27, !28, !30, !34, !36}
!20 = !DILocalVariable(name: "ni", arg: 1, scope: !9, file: !1, line: 3, type: !12)
!21 = !DILocalVariable(name: "nj", arg: 2, scope: !9, file: !1, line: 3, type: !12)
!22 = !DILocalVariable(name: "nk", arg: 3, scope: !9, file: !1, line: 3, type: !12)
!23 = !DILocalVariable(name: "alpha", arg: 4, scope: !9, file: !1, line: 3, type: !13)
!24 = !DILocalVariable(name: "beta", arg: 5, scope: !9, file: !1, line: 3, type: !13)
!25 = !DILocalVariable(name: "c", arg: 6, scope: !9, file: !1, line: 3, type: !14)
!26 = !DILocalVariable(name: "a", arg: 7, scope: !9, file: !1, line: 4, type: !16)
!27 = !DILocalVariable(name: "b", arg: 8, scope: !9, file: !1, line: 4, type: !16)
!28 = !DILocalVariable(name: "i", scope: !29, file: !1, line: 6, type: !12)
!29 = distinct !DILexicalBlock(scope: !9, file: !1, line: 6, column: 5)
!30 = !DILocalVariable(name: "j", scope: !31, file: !1, line: 7, type: !12)
!31 = distinct !DILexicalBlock(scope: !32, file: !1, line: 7, column: 9)
!32 = distinct !DILexicalBlock(scope: !33, file: !1, line: 6, column: 34)
!33 = distinct !DILexicalBlock(scope: !29, file: !1, line: 6, column: 5)
!34 = !DILocalVariable(name: "k", scope: !35, file: !1, line: 9, type: !12)
!35 = distinct !DILexicalBlock(scope: !32, file: !1, line: 9, column: 9)
!36 = !DILocalVariable(name: "j", scope: !37, file: !1, line: 10, type: !12)
!37 = distinct !DILexicalBlock(scope: !38, file: !1, line: 10, column: 13)
!38 = distinct !DILexicalBlock(scope: !35, file: !1, line: 9, column: 9)
!39 = !DILocation(line: 0, scope: !9)
!40 = !DILocation(line: 0, scope: !29)
!41 = !DILocation(line: 6, column: 23, scope: !33)
!42 = !DILocation(line: 6, column: 5, scope: !29)
!43 = !DILocation(line: 0, scope: !31)
!44 = !DILocation(line: 7, column: 9, scope: !31)
!45 = !DILocation(line: 13, column: 1, scope: !9)
!46 = !DILocation(line: 0, scope: !35)
!47 = !DILocation(line: 9, column: 9, scope: !35)
!48 = !DILocation(line: 8, column: 22, scope: !49)
!49 = distinct !DILexicalBlock(scope: !31, file: !1, line: 7, column: 9)
!50 = !DILocation(line: 8, column: 13, scope: !49)
!51 = !DILocation(line: 8, column: 27, scope: !49)
!52 = !{!53, !53, i64 0}
!53 = !{!"float", !54, i64 0}
!54 = !{!"omnipotent char", !55, i64 0}
!55 = !{!"Simple C/C++ TBAA"}
!56 = !DILocation(line: 7, column: 34, scope: !49)
!57 = !DILocation(line: 7, column: 27, scope: !49)
!58 = distinct !{!58, !44, !59, !60, !61}
!59 = !DILocation(line: 8, column: 30, scope: !31)
!60 = !{!"llvm.loop.mustprogress"}
!61 = !{!"llvm.loop.unroll.disable"}
!62 = !DILocation(line: 0, scope: !37)
!63 = !DILocation(line: 10, column: 13, scope: !37)
!64 = !DILocation(line: 6, column: 30, scope: !33)
!65 = distinct !{!65, !42, !66, !60, !61}
!66 = !DILocation(line: 12, column: 5, scope: !29)
!67 = !DILocation(line: 9, column: 34, scope: !38)
!68 = !DILocation(line: 9, column: 27, scope: !38)
!69 = distinct !{!69, !47, !70, !60, !61}
!70 = !DILocation(line: 11, column: 70, scope: !35)
!71 = !DILocation(line: 11, column: 67, scope: !72)
!72 = distinct !DILexicalBlock(scope: !37, file: !1, line: 10, column: 13)
!73 = !DILocation(line: 11, column: 58, scope: !72)
!74 = !DILocation(line: 11, column: 26, scope: !72)
!75 = !DILocation(line: 11, column: 17, scope: !72)
!76 = !DILocation(line: 11, column: 31, scope: !72)
!77 = !DILocation(line: 10, column: 38, scope: !72)
!78 = !DILocation(line: 10, column: 31, scope: !72)
!79 = distinct !{!79, !63, !80, !60, !61}
!80 = !DILocation(line: 11, column: 70, scope: !37)
!81 = distinct !DISubprogram(name: "atax", scope: !1, file: !1, line: 16, type: !82, scopeLine: 17, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !88)
!82 = !DISubroutineType(types: !83)
!83 = !{null, !12, !12, !84, !15, !15, !15}
!84 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !85, size: 64)
!85 = !DICompositeType(tag: DW_TAG_array_type, baseType: !13, elements: !86)
!86 = !{!87}
!87 = !DISubrange(count: -1)
!88 = !{!89, !90, !91, !92, !93, !94, !95, !97, !99, !103}
!89 = !DILocalVariable(name: "m", arg: 1, scope: !81, file: !1, line: 16, type: !12)
!90 = !DILocalVariable(name: "n", arg: 2, scope: !81, file: !1, line: 16, type: !12)
!91 = !DILocalVariable(name: "a", arg: 3, scope: !81, file: !1, line: 16, type: !84)
!92 = !DILocalVariable(name: "x", arg: 4, scope: !81, file: !1, line: 16, type: !15)
!93 = !DILocalVariable(name: "y", arg: 5, scope: !81, file: !1, line: 16, type: !15)
!94 = !DILocalVariable(name: "tmp", arg: 6, scope: !81, file: !1, line: 16, type: !15)
!95 = !DILocalVariable(name: "j", scope: !96, file: !1, line: 18, type: !12)
!96 = distinct !DILexicalBlock(scope: !81, file: !1, line: 18, column: 5)
!97 = !DILocalVariable(name: "i", scope: !98, file: !1, line: 20, type: !12)
!98 = distinct !DILexicalBlock(scope: !81, file: !1, line: 20, column: 5)
!99 = !DILocalVariable(name: "j", scope: !100, file: !1, line: 22, type: !12)
!100 = distinct !DILexicalBlock(scope: !101, file: !1, line: 22, column: 9)
!101 = distinct !DILexicalBlock(scope: !102, file: !1, line: 20, column: 33)
!102 = distinct !DILexicalBlock(scope: !98, file: !1, line: 20, column: 5)
!103 = !DILocalVariable(name: "j", scope: !104, file: !1, line: 24, type: !12)
!104 = distinct !DILexicalBlock(scope: !101, file: !1, line: 24, column: 9)
!105 = !DILocation(line: 0, scope: !81)
!106 = !DILocation(line: 0, scope: !96)
!107 = !DILocation(line: 18, column: 23, scope: !108)
!108 = distinct !DILexicalBlock(scope: !96, file: !1, line: 18, column: 5)
!109 = !DILocation(line: 18, column: 5, scope: !96)
!110 = !DILocation(line: 19, column: 14, scope: !108)
!111 = !DILocation(line: 20, column: 23, scope: !102)
!112 = !DILocation(line: 0, scope: !98)
!113 = !DILocation(line: 20, column: 5, scope: !98)
!114 = !DILocation(line: 27, column: 1, scope: !81)
!115 = !DILocation(line: 21, column: 9, scope: !101)
!116 = !DILocation(line: 21, column: 16, scope: !101)
!117 = !DILocation(line: 0, scope: !100)
!118 = !DILocation(line: 22, column: 9, scope: !100)
!119 = !DILocation(line: 0, scope: !104)
!120 = !DILocation(line: 24, column: 9, scope: !104)
!121 = !DILocation(line: 23, column: 23, scope: !122)
!122 = distinct !DILexicalBlock(scope: !100, file: !1, line: 22, column: 9)
!123 = !DILocation(line: 23, column: 33, scope: !122)
!124 = !DILocation(line: 23, column: 20, scope: !122)
!125 = !DILocation(line: 22, column: 33, scope: !122)
!126 = !DILocation(line: 22, column: 27, scope: !122)
!127 = distinct !{!127, !118, !128, !60, !61}
!128 = !DILocation(line: 23, column: 36, scope: !100)
!129 = !DILocation(line: 20, column: 29, scope: !102)
!130 = distinct !{!130, !113, !131, !60, !61}
!131 = !DILocation(line: 26, column: 5, scope: !98)
!132 = !DILocation(line: 25, column: 21, scope: !133)
!133 = distinct !DILexicalBlock(scope: !104, file: !1, line: 24, column: 9)
!134 = !DILocation(line: 25, column: 31, scope: !133)
!135 = !DILocation(line: 25, column: 13, scope: !133)
!136 = !DILocation(line: 25, column: 18, scope: !133)
!137 = !DILocation(line: 24, column: 33, scope: !133)
!138 = !DILocation(line: 24, column: 27, scope: !133)
!139 = distinct !{!139, !120, !140, !60, !61}
!140 = !DILocation(line: 25, column: 36, scope: !104)
!141 = distinct !DISubprogram(name: "mvt", scope: !1, file: !1, line: 29, type: !142, scopeLine: 30, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !144)
!142 = !DISubroutineType(types: !143)
!143 = !{null, !12, !15, !15, !17, !17, !84}
!144 = !{!145, !146, !147, !148, !149, !150, !151, !153, !156, !158}
!145 = !DILocalVariable(name: "n", arg: 1, scope: !141, file: !1, line: 29, type: !12)
!146 = !DILocalVariable(name: "x1", arg: 2, scope: !141, file: !1, line: 29, type: !15)
!147 = !DILocalVariable(name: "x2", arg: 3, scope: !141, file: !1, line: 29, type: !15)
!148 = !DILocalVariable(name: "y1", arg: 4, scope: !141, file: !1, line: 29, type: !17)
!149 = !DILocalVariable(name: "y2", arg: 5, scope: !141, file: !1, line: 29, type: !17)
!150 = !DILocalVariable(name: "a", arg: 6, scope: !141, file: !1, line: 29, type: !84)
!151 = !DILocalVariable(name: "i", scope: !152, file: !1, line: 31, type: !12)
!152 = distinct !DILexicalBlock(scope: !141, file: !1, line: 31, column: 5)
!153 = !DILocalVariable(name: "j", scope: !154, file: !1, line: 32, type: !12)
!154 = distinct !DILexicalBlock(scope: !155, file: !1, line: 32, column: 9)
!155 = distinct !DILexicalBlock(scope: !152, file: !1, line: 31, column: 5)
!156 = !DILocalVariable(name: "i", scope: !157, file: !1, line: 34, type: !12)
!157 = distinct !DILexicalBlock(scope: !141, file: !1, line: 34, column: 5)
!158 = !DILocalVariable(name: "j", scope: !159, file: !1, line: 35, type: !12)
!159 = distinct !DILexicalBlock(scope: !160, file: !1, line: 35, column: 9)
!160 = distinct !DILexicalBlock(scope: !157, file: !1, line: 34, column: 5)
!161 = !DILocation(line: 0, scope: !141)
!162 = !DILocation(line: 0, scope: !152)
!163 = !DILocation(line: 31, column: 23, scope: !155)
!164 = !DILocation(line: 31, column: 5, scope: !152)
!165 = !DILocation(line: 0, scope: !154)
!166 = !DILocation(line: 32, column: 9, scope: !154)
!167 = !DILocation(line: 0, scope: !157)
!168 = !DILocation(line: 34, column: 23, scope: !160)
!169 = !DILocation(line: 34, column: 5, scope: !157)
!170 = !DILocation(line: 31, column: 29, scope: !155)
!171 = distinct !{!171, !164, !172, !60, !61}
!172 = !DILocation(line: 33, column: 43, scope: !152)
!173 = !DILocation(line: 33, column: 29, scope: !174)
!174 = distinct !DILexicalBlock(scope: !154, file: !1, line: 32, column: 9)
!175 = !DILocation(line: 33, column: 39, scope: !174)
!176 = !DILocation(line: 33, column: 27, scope: !174)
!177 = !DILocation(line: 33, column: 19, scope: !174)
!178 = !DILocation(line: 32, column: 33, scope: !174)
!179 = !DILocation(line: 32, column: 27, scope: !174)
!180 = distinct !{!180, !166, !181, !60, !61}
!181 = !DILocation(line: 33, column: 43, scope: !154)
!182 = !DILocation(line: 0, scope: !159)
!183 = !DILocation(line: 35, column: 9, scope: !159)
!184 = !DILocation(line: 37, column: 1, scope: !141)
!185 = !DILocation(line: 34, column: 29, scope: !160)
!186 = distinct !{!186, !169, !187, !60, !61}
!187 = !DILocation(line: 36, column: 43, scope: !157)
!188 = !DILocation(line: 36, column: 29, scope: !189)
!189 = distinct !DILexicalBlock(scope: !159, file: !1, line: 35, column: 9)
!190 = !DILocation(line: 36, column: 39, scope: !189)
!191 = !DILocation(line: 36, column: 27, scope: !189)
!192 = !DILocation(line: 36, column: 19, scope: !189)
!193 = !DILocation(line: 35, column: 33, scope: !189)
!194 = !DILocation(line: 35, column: 27, scope: !189)
!195 = distinct !{!195, !183, !196, !60, !61}
!196 = !DILocation(line: 36, column: 43, scope: !159)
!197 = distinct !DISubprogram(name: "transpose", scope: !1, file: !1, line: 39, type: !198, scopeLine: 40, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !201)
!198 = !DISubroutineType(types: !199)
!199 = !{null, !200, !12}
!200 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !12, size: 64)
!201 = !{!202, !203, !204, !206, !209}
!202 = !DILocalVariable(name: "a", arg: 1, scope: !197, file: !1, line: 39, type: !200)
!203 = !DILocalVariable(name: "n", arg: 2, scope: !197, file: !1, line: 39, type: !12)
!204 = !DILocalVariable(name: "i", scope: !205, file: !1, line: 41, type: !12)
!205 = distinct !DILexicalBlock(scope: !197, file: !1, line: 41, column: 5)
!206 = !DILocalVariable(name: "j", scope: !207, file: !1, line: 42, type: !12)
!207 = distinct !DILexicalBlock(scope: !208, file: !1, line: 42, column: 9)
!208 = distinct !DILexicalBlock(scope: !205, file: !1, line: 41, column: 5)
!209 = !DILocalVariable(name: "t", scope: !210, file: !1, line: 43, type: !12)
!210 = distinct !DILexicalBlock(scope: !211, file: !1, line: 42, column: 41)
!211 = distinct !DILexicalBlock(scope: !207, file: !1, line: 42, column: 9)
!212 = !DILocation(line: 0, scope: !197)
!213 = !DILocation(line: 0, scope: !205)
!214 = !DILocation(line: 41, column: 23, scope: !208)
!215 = !DILocation(line: 41, column: 5, scope: !205)
!216 = distinct !{!216, !215, !217, !60, !61}
!217 = !DILocation(line: 46, column: 9, scope: !205)
!218 = !DILocation(line: 47, column: 1, scope: !197)
!219 = !DILocation(line: 42, column: 24, scope: !207)
!220 = !DILocation(line: 0, scope: !207)
!221 = !DILocation(line: 42, column: 31, scope: !211)
!222 = !DILocation(line: 42, column: 9, scope: !207)
!223 = !DILocation(line: 43, column: 29, scope: !210)
!224 = !DILocation(line: 43, column: 21, scope: !210)
!225 = !{!226, !226, i64 0}
!226 = !{!"int", !54, i64 0}
!227 = !DILocation(line: 0, scope: !210)
!228 = !DILocation(line: 44, column: 32, scope: !210)
!229 = !DILocation(line: 44, column: 36, scope: !210)
!230 = !DILocation(line: 44, column: 28, scope: !210)
!231 = !DILocation(line: 44, column: 26, scope: !210)
!232 = !DILocation(line: 45, column: 26, scope: !210)
!233 = !DILocation(line: 42, column: 37, scope: !211)
!234 = distinct !{!234, !222, !235, !60, !61}
!235 = !DILocation(line: 46, column: 9, scope: !207)
!236 = distinct !DISubprogram(name: "trisolv", scope: !1, file: !1, line: 50, type: !237, scopeLine: 51, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !239)
!237 = !DISubroutineType(types: !238)
!238 = !{null, !12, !17, !15, !17}
!239 = !{!240, !241, !242, !243, !244, !246, !249}
!240 = !DILocalVariable(name: "n", arg: 1, scope: !236, file: !1, line: 50, type: !12)
!241 = !DILocalVariable(name: "l", arg: 2, scope: !236, file: !1, line: 50, type: !17)
!242 = !DILocalVariable(name: "x", arg: 3, scope: !236, file: !1, line: 50, type: !15)
!243 = !DILocalVariable(name: "b", arg: 4, scope: !236, file: !1, line: 50, type: !17)
!244 = !DILocalVariable(name: "i", scope: !245, file: !1, line: 52, type: !12)
!245 = distinct !DILexicalBlock(scope: !236, file: !1, line: 52, column: 5)
!246 = !DILocalVariable(name: "sum", scope: !247, file: !1, line: 53, type: !13)
!247 = distinct !DILexicalBlock(scope: !248, file: !1, line: 52, column: 33)
!248 = distinct !DILexicalBlock(scope: !245, file: !1, line: 52, column: 5)
!249 = !DILocalVariable(name: "j", scope: !250, file: !1, line: 54, type: !12)
!250 = distinct !DILexicalBlock(scope: !247, file: !1, line: 54, column: 9)
!251 = !DILocation(line: 0, scope: !236)
!252 = !DILocation(line: 0, scope: !245)
!253 = !DILocation(line: 52, column: 23, scope: !248)
!254 = !DILocation(line: 52, column: 5, scope: !245)
!255 = !DILocation(line: 58, column: 1, scope: !236)
!256 = !DILocation(line: 53, column: 21, scope: !247)
!257 = !DILocation(line: 0, scope: !247)
!258 = !DILocation(line: 0, scope: !250)
!259 = !DILocation(line: 54, column: 27, scope: !260)
!260 = distinct !DILexicalBlock(scope: !250, file: !1, line: 54, column: 9)
!261 = !DILocation(line: 54, column: 9, scope: !250)
!262 = !DILocation(line: 56, column: 30, scope: !247)
!263 = !DILocation(line: 56, column: 22, scope: !247)
!264 = !DILocation(line: 56, column: 20, scope: !247)
!265 = !DILocation(line: 56, column: 9, scope: !247)
!266 = !DILocation(line: 56, column: 14, scope: !247)
!267 = !DILocation(line: 52, column: 29, scope: !248)
!268 = distinct !{!268, !254, !269, !60, !61}
!269 = !DILocation(line: 57, column: 5, scope: !245)
!270 = !DILocation(line: 55, column: 28, scope: !260)
!271 = !DILocation(line: 55, column: 20, scope: !260)
!272 = !DILocation(line: 55, column: 35, scope: !260)
!273 = !DILocation(line: 55, column: 17, scope: !260)
!274 = !DILocation(line: 54, column: 33, scope: !260)
!275 = distinct !{!275, !261, !276, !60, !61}
!276 = !DILocation(line: 55, column: 38, scope: !250)
